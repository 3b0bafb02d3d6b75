// A file on its way to its name. It is written under another name in the same folder, NAME.new- and sixteen
// hex digits, and takes its name when it is whole, so that nobody ever sees half of it. As long as its writer
// lives it is locked; what a killed writer left behind can be told by that, and removed. Threads: one at a
// time.
#pragma once

#include <filesystem>
#include <vector>

#include "store/io/file.h"
#include "store/result.h"

namespace vt::store {

// Makes the file that will be called `target`, open for writing and locked. Its name cannot be guessed, and
// nothing that has it, link or file, is ever opened. With `replaced`, the open file whose place it is to
// take, it has that one's mode and owner from the start; kIo when it cannot have them.
[[nodiscard]] Result<File> create_beside(const std::filesystem::path& target, const File* replaced = nullptr);

// Gives `file` its name and makes that durable when `sync`. kExists when something has it.
[[nodiscard]] Result<void> take_name(File& file, const std::filesystem::path& target, bool sync);
// The same in the place of `replaced`. kExists when the name leads to another file by now, which then keeps
// it. Who has `replaced` open keeps it.
[[nodiscard]] Result<void> take_place(File& file, const std::filesystem::path& target, const File& replaced, bool sync);

// Removes what killed writers of `target` left in its folder, and says what that was. Files of writers that
// are at work stay, and so does a whole store under the kind of name that older programs gave, which can be
// somebody's own.
std::vector<std::filesystem::path> remove_leftovers(const std::filesystem::path& target);

}  // namespace vt::store
