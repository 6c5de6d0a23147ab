#include <palpate/live/run_signals.h>

#include <array>
#include <atomic>
#include <csignal>
#include <utility>

#include <poll.h>

namespace palpate {
namespace {

// State that signal handlers access.
std::atomic<bool> ends = false;
std::atomic<const std::vector<LiveSystem*>*> stoppable = nullptr;
static_assert(decltype(stoppable)::is_always_lock_free);

template <class Stop>
void for_all(const Stop& stop) {
  if (const auto* systems = stoppable.load(std::memory_order_acquire))
    for (LiveSystem* system : *systems) stop(*system);
}
void stop_for(Fault why) {
  for_all([why](LiveSystem& system) { system.stop_force(why); });
}
extern "C" void end_run(int) {
  ends.store(true, std::memory_order_relaxed);
  stop_for(Fault::kEnded);
}
extern "C" void stop_motors(int) { stop_for(Fault::kEmergencyStop); }
/// Stops the devices, then terminates the program by the same signal. They are stopped again once a write
/// that a loop was making has ended.
extern "C" void die(int signal) {
  constexpr int kWrite = 5;  // ms
  const auto stop = [](LiveSystem& system) { system.stop_motors(); };
  for_all(stop);
  ::poll(nullptr, 0, kWrite);  // a function that handlers may call
  for_all(stop);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Its handler runs although the stack of the thread has overflowed, if the thread has a SignalStack.
void handle_on_own_stack(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_ONSTACK;
  sigaction(signal, &action, nullptr);
}

constexpr std::array<int, 4> kEnding{SIGINT, SIGTERM, SIGHUP, SIGQUIT};
constexpr std::array<int, 5> kDeadly{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

}  // namespace

RunSignals::RunSignals(std::vector<LiveSystem*> systems) : systems_(std::move(systems)) {
  stoppable.store(&systems_, std::memory_order_release);
  for (const int signal : kEnding) std::signal(signal, end_run);
  for (const int signal : kDeadly) handle_on_own_stack(signal, die);
  std::signal(SIGUSR1, stop_motors);
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

RunSignals::~RunSignals() {
  for (const int signal : kEnding) std::signal(signal, SIG_DFL);
  for (const int signal : kDeadly) std::signal(signal, SIG_DFL);
  std::signal(SIGUSR1, SIG_IGN);
  stoppable.store(nullptr, std::memory_order_release);
}

bool RunSignals::ended() { return ends.load(std::memory_order_relaxed); }

}  // namespace palpate
