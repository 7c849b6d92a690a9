#include <benchmark/benchmark.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <ctime>
#include <exception>
#include <vector>

#include "tests/bench/processes.h"

namespace pickbed::tests {
namespace {

// Mesa writes compiled shaders to disk in a separate thread. A process that is forked after drawing
// lacks this thread and would wait for it forever, so the shader cache is disabled.
const bool kNoShaderThread = setenv("MESA_SHADER_CACHE_DISABLE", "true", 1) == 0;

struct Worker {
  pid_t pid = -1;
  int start = -1;  // a byte written to it starts the steps; closing it ends the process
  int done = -1;   // returns the CPU seconds of the steps when they are done
};

[[noreturn]] void Serve(int start, int done, int steps,
                        const std::function<std::function<void()>()>& make_work) {
  try {
    const std::function<void()> work = make_work();
    work();  // compiles shaders and creates framebuffers
    char byte = 0;
    double cpu_s = 0;
    do {
      if (write(done, &cpu_s, sizeof(cpu_s)) != sizeof(cpu_s)) _exit(1);
      if (read(start, &byte, 1) != 1) break;
      const std::clock_t begin = std::clock();
      for (int i = 0; i < steps; ++i) work();
      cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    } while (true);
  } catch (const std::exception&) {
    _exit(1);
  }
  _exit(0);
}

Worker StartWorker(int steps, const std::function<std::function<void()>()>& make_work) {
  std::array<int, 2> start{}, done{};
  Worker worker;
  if (pipe(start.data()) != 0 || pipe(done.data()) != 0) return worker;
  worker.pid = fork();
  if (worker.pid == 0) {
    close(start[1]);
    close(done[0]);
    Serve(start[0], done[1], steps, make_work);
  }
  close(start[0]);
  close(done[1]);
  worker.start = start[1];
  worker.done = done[0];
  return worker;
}

// Waits for all workers and adds their CPU time to `cpu_s`. Returns false if one failed.
bool WaitForAll(const std::vector<Worker>& workers, double& cpu_s) {
  bool ok = true;
  for (const Worker& worker : workers) {
    double seconds = 0;
    ok &= read(worker.done, &seconds, sizeof(seconds)) == sizeof(seconds);
    cpu_s += seconds;
  }
  return ok;
}

}  // namespace

void MeasureInProcesses(benchmark::State& state, int steps,
                        const std::function<std::function<void()>()>& make_work,
                        int items_per_step) {
  std::vector<Worker> workers;
  if (!kNoShaderThread) state.SkipWithError("cannot set the environment");
  for (int i = 0; i < state.range(0); ++i) workers.push_back(StartWorker(steps, make_work));
  double cpu_s = 0;
  bool ok = WaitForAll(workers, cpu_s);
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    for (const Worker& worker : workers) ok &= ok && write(worker.start, "", 1) == 1;
    ok = ok && WaitForAll(workers, cpu_s);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    state.SetIterationTime(seconds.count());
    if (!ok) state.SkipWithError("a worker process failed");
    if (!ok) break;
  }
  for (const Worker& worker : workers) close(worker.start);
  for (const Worker& worker : workers) {
    close(worker.done);
    waitpid(worker.pid, nullptr, 0);
  }
  const auto items = state.iterations() * state.range(0) * steps * items_per_step;
  state.SetItemsProcessed(items);
  state.counters["items_per_cpu_second"] = items / cpu_s;
}

}  // namespace pickbed::tests
