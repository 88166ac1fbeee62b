#pragma once

/// The version of takt, in one place: CMakeLists.txt reads it here. Semantic versioning; while the first number is 0,
/// the second counts as the one that breaks.
#define TAKT_VERSION_MAJOR 0
#define TAKT_VERSION_MINOR 1
#define TAKT_VERSION_PATCH 0

#define TAKT_VERSION_TEXT_OF(major, minor, patch) #major "." #minor "." #patch
#define TAKT_VERSION_TEXT_FROM(major, minor, patch) TAKT_VERSION_TEXT_OF(major, minor, patch)
/// "0.1.0"
#define TAKT_VERSION TAKT_VERSION_TEXT_FROM(TAKT_VERSION_MAJOR, TAKT_VERSION_MINOR, TAKT_VERSION_PATCH)
