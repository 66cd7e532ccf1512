"""From a specification to an OpenCL program: templates, structures, build, and how it is run."""
