#include "eval/cli/commands.h"
#include "eval/runtime/process.h"

int main(int argc, char** argv) {
  pickbed::eval::UseOneThread();
  pickbed::eval::ExitOnInterrupt();
  return pickbed::eval::Dispatch(argc, argv);
}
