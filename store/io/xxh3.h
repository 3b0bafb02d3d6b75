// xxHash as this library uses it: the library's own choice of vector unit at run time where it has one
// (x86-64), which doubles the rate of checksums over the baseline. The hashes are the same everywhere.
// Private to the files that hash.
#pragma once

#define XXH_STATIC_LINKING_ONLY
#include <xxhash.h>
#if defined(__x86_64__)
#include <xxh_x86dispatch.h>
#endif
