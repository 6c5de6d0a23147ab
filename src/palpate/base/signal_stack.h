/// \file
/// Stack for signal handlers.
#pragma once

#include <cstddef>
#include <memory>

#include <csignal>

namespace palpate {

/// Alternate signal stack of the calling thread (sigaltstack) for its lifetime, so that handlers installed
/// with SA_ONSTACK run although the thread's own stack has overflowed. Constructed and destroyed on one
/// thread.
class SignalStack {
 public:
  SignalStack();
  /// Restores the stack of before.
  ~SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  std::unique_ptr<std::byte[]> memory_;
  stack_t before_{};
};

}  // namespace palpate
