/// \file
/// What a person sees while a command runs.
#pragma once

#include <palpate/base/progress.h>

namespace palpate::cli {

/// A progress bar on stderr, or nothing at all if stderr is not a terminal or `quiet` is set.
Progress terminal_progress(bool quiet);

}  // namespace palpate::cli
