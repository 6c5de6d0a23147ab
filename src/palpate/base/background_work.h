/// \file
/// What a slower thread does for a faster one.
#pragma once

namespace palpate {

/// Work that is done over and over beside a loop that must not wait for it: what is asked for is taken at one
/// time, and the answer is there at a later one.
class BackgroundWork {
 public:
  virtual ~BackgroundWork() = default;

  /// Takes what is asked for now.
  virtual void take() = 0;
  /// Does what was taken, and hands it over.
  virtual void finish() = 0;
};

}  // namespace palpate
