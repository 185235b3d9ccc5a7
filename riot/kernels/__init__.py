"""Numba kernels: plain arrays in and out, one module a hot loop; geometry, policy and files stay outside."""
