//! Mistakes in users' kernels are named with their places.
