#include "eval/commands.h"
#include "eval/interrupt.h"
#include "eval/threads.h"

int main(int argc, char** argv) {
  pickbed::UseOneThread();
  pickbed::ExitOnInterrupt();
  return pickbed::Dispatch(argc, argv);
}
