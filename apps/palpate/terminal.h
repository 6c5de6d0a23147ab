/// \file
/// Terminal output while a command runs.
#pragma once

#include <palpate/base/progress.h>

namespace palpate::cli {

/// Opens /dev/null in place of stdin, stdout and stderr if they are closed: a file opened later would
/// otherwise get their descriptor.
void open_closed_streams();

/// A progress bar on stderr, or nothing at all if stderr is not a terminal or `quiet` is set.
Progress terminal_progress(bool quiet);

}  // namespace palpate::cli
