// Fresh rays.  Ray i of a batch belongs to the source whose range of i holds it.  Emission functions take
// the source's row and two pairs of uniforms in [0, 1); those of sources that draw no position make no
// use of the second.
