#include "eval/commands.h"
#include "eval/threads.h"

int main(int argc, char** argv) {
  pickbed::UseOneThread();
  return pickbed::Dispatch(argc, argv);
}
