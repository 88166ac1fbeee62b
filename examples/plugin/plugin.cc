#include "core/plugin/plugin.h"

TAKT_PLUGIN("fan", "1.0.0");
