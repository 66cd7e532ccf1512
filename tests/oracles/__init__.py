"""Slow, obvious references and small drivers that the engine's tests share.

Nothing here shares code with the product's computations: `philox`, `numbers` and `tracer` are
written anew from the papers and the contract; `engine` and `kernels` only drive the product, and
`gates` holds the checks that both the tests and the mutants call.
"""
