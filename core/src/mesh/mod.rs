//! Surface meshes: the OBJ document, generators and checks.
