"""The C on other machines: cross compilers, the images that they build, and the emulators that run them."""
