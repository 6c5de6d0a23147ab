/// \file
/// Slow work beside a thread that must not wait for it.
#pragma once

#include <functional>

namespace palpate {

/// Has `work` done on another thread, of ordinary priority and one after the other, and then `then` on the
/// thread that asked. Returns at once; neither may throw. Where the program ends before, neither need be
/// called. Both are destroyed on the thread that calls them.
using Elsewhere = std::function<void(std::function<void()> work, std::function<void()> then)>;

}  // namespace palpate
