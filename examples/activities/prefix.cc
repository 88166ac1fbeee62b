// Nothing: <takt/takt.h> is compiled with it, once for all programs (CMakeLists.txt).
