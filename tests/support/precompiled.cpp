// Nothing: the headers that are precompiled need a target, and a target a source.
