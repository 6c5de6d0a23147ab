#include <palpate/base/signal_stack.h>

namespace palpate {
namespace {

/// For handlers that call drivers. Unit: bytes.
constexpr std::size_t kSize = 65536;

}  // namespace

SignalStack::SignalStack() : memory_(std::make_unique<std::byte[]>(kSize)) {
  stack_t stack{};
  stack.ss_sp = memory_.get();
  stack.ss_size = kSize;
  sigaltstack(&stack, &before_);
}

SignalStack::~SignalStack() { sigaltstack(&before_, nullptr); }

}  // namespace palpate
