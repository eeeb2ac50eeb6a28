// SPDX-License-Identifier: MIT
// The files that a command reads, which it may not write over.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "host/shots/shot.h"

namespace penumbra {

using FileList = std::vector<std::filesystem::path>;

// A shot with its models, what these consist of, and its environment. `made_up`: the shot itself is no file.
FileList files_of_shot(const Shot& shot, bool made_up = false);
// With all that they extend.
FileList files_of_pipelines(const std::vector<std::string>& files);
// Declarations, shaders and tables that folders of nodes hold.
FileList files_of_nodes(const std::vector<std::string>& folders);

// Before any work is done: false, with an error, where one of the files to be written is another of them, or
// one of those that are read, whatever its name there.
bool spares(const FileList& written, std::initializer_list<FileList> read, Diagnostics& diagnostics);

}  // namespace penumbra
