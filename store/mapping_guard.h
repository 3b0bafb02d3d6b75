// What becomes of a program when another one cuts a store off that it is reading: by default SIGBUS ends it.
#pragma once

namespace vt::store {

// From now on a fault inside a store's memory map ends in zeros and, for whoever reads the store, in kIo; a
// SIGBUS of any other origin goes to the handler that was there before. It is the process's signal handler,
// so the program decides about it and no library of ours does. Any thread; calling it again changes nothing.
void guard_mappings();

}  // namespace vt::store
