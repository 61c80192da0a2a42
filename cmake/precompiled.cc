// Compiled by the owners of precompiled headers, which must compile something.
