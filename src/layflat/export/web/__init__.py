"""Laws and plants in browsers: a WebAssembly module, a small ES module around it, and a page that needs no server."""
