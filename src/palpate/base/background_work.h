/// \file
/// Interface of background work that a slower thread does for a faster one.
#pragma once

namespace palpate {

/// Work repeated on a background thread beside a loop that must not wait for it: each round takes the current
/// request and later publishes its result.
class BackgroundWork {
 public:
  virtual ~BackgroundWork() = default;

  /// Takes the current request.
  virtual void take() = 0;
  /// Processes the request that take() took, and publishes the result.
  virtual void finish() = 0;
};

}  // namespace palpate
