#include "pipeline/cli/interruption.hpp"

#include <csignal>
#include <string_view>

#include <sys/time.h>
#include <unistd.h>

#include "pipeline/execution/error.hpp"

namespace meshmser {
namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may not lock");

extern "C" void on_interruption(int) {
  interrupted.store(true, std::memory_order_relaxed);
  // Soon enough that the program has ended within a second, its memory given back. A plain system call on Linux.
  constexpr itimerval kPatience{{0, 0}, {0, 700'000}};
  setitimer(ITIMER_REAL, &kPatience, nullptr);
}

extern "C" void on_alarm(int) {
  constexpr std::string_view kMessage = "\nmeshmser: interrupted; every stage that finished is cached\n";
  // Nothing can be done about a message that cannot be written.
  if (write(STDERR_FILENO, kMessage.data(), kMessage.size()) < 0) _exit(static_cast<int>(ExitCode::kInterrupted));
  _exit(static_cast<int>(ExitCode::kInterrupted));
}

void handle(int signal, void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

const std::atomic<bool>& watch_for_interruption() {
  handle(SIGALRM, on_alarm);
  handle(SIGINT, on_interruption);
  handle(SIGTERM, on_interruption);
  return interrupted;
}

}  // namespace meshmser
