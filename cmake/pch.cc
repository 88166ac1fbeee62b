// The object that carries the precompiled header; nothing else belongs here.
