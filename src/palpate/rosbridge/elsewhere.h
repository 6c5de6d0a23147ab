/// \file
/// Executor for slow work of threads that must not block.
#pragma once

#include <functional>

namespace palpate {

/// Runs `work` on another thread, of normal priority and in order, and then `then` on the calling thread.
/// Returns immediately; neither may throw. If the program ends first, they may not be called. Each is
/// destroyed on the thread that calls it.
using Elsewhere = std::function<void(std::function<void()> work, std::function<void()> then)>;

}  // namespace palpate
