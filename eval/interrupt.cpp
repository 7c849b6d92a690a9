#include "eval/interrupt.h"

#include <signal.h>
#include <unistd.h>

namespace pickbed {
namespace {

volatile sig_atomic_t g_interrupted = 0;

void ExitNow(int) {
  constexpr char kMessage[] = "pickbed: interrupted\n";
  // write() is safe in a handler, printing is not.
  if (write(STDERR_FILENO, kMessage, sizeof(kMessage) - 1) < 0) _exit(kExitInterrupted);
  _exit(kExitInterrupted);
}

void SetFlag(int signal) {
  if (g_interrupted) ExitNow(signal);
  g_interrupted = 1;
}

void Handle(void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  // No SA_RESTART: a poll() that waits for workers is to wake up.
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

void ExitOnInterrupt() { Handle(ExitNow); }
void CatchInterrupts() { Handle(SetFlag); }
bool Interrupted() { return g_interrupted != 0; }

}  // namespace pickbed
