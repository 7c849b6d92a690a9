#include "eval/interrupt.h"

#include <signal.h>
#include <unistd.h>

namespace pickbed {
namespace {

volatile sig_atomic_t g_interrupted = 0;

void OnSignal(int) {
  if (g_interrupted) _exit(kExitInterrupted);
  g_interrupted = 1;
}

}  // namespace

void CatchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  sigemptyset(&action.sa_mask);
  // No SA_RESTART: a poll() that waits for workers is to wake up.
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool Interrupted() { return g_interrupted != 0; }

}  // namespace pickbed
