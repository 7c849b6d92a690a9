#!/usr/bin/python3
"""Measures what the Python environment costs beside the same trials in C++.

    PYTHONPATH=build/release/python python_bench.py [--scenario clutter] [--set KEY=VALUE] [--steps 100]

Each bin is picked twice in this process: as one C++ call (Cell.run_trial) and step by step
(BinPickingEnv). The order alternates from bin to bin, so that drift of the machine affects both. The
records must be equal, byte by byte.
"""

import argparse
import statistics
import time

import pickbed


def timed(work):
    cpu, wall = time.process_time(), time.perf_counter()
    result = work()
    return result, time.process_time() - cpu, time.perf_counter() - wall


def step_through(env, bin_index):
    env.reset(options={"bin_index": bin_index})
    hashes, done = [], False
    while not done:
        _, _, terminated, truncated, info = env.step(env.choose_grasp())
        hashes.append(info["record"].hashes)
        done = terminated or truncated
    return hashes


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--scenario", default="clutter")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--steps", type=int, default=100)
    arguments = parser.parse_args()
    scenario = pickbed.Scenario(arguments.scenario, arguments.set)
    cell, env = pickbed.Cell(scenario), pickbed.BinPickingEnv(scenario)
    in_cpp = lambda bin_index: [record.hashes for record in cell.run_trial(bin_index).attempts]
    in_python = lambda bin_index: step_through(env, bin_index)
    in_cpp(0), in_python(0)  # loads the estimator and compiles the shaders

    steps, bin_index, cpu, wall = 0, 0, [], []
    while steps < arguments.steps:
        bin_index += 1
        order = [in_cpp, in_python] if bin_index % 2 else [in_python, in_cpp]
        results = {work: timed(lambda work=work: work(bin_index)) for work in order}
        if results[in_cpp][0] != results[in_python][0]:
            raise SystemExit(f"bin {bin_index}: the records differ")
        steps += len(results[in_python][0])
        cpu.append((results[in_cpp][1], results[in_python][1]))
        wall.append((results[in_cpp][2], results[in_python][2]))
    print(f"{steps} steps in {bin_index} bins, all records equal")
    for name, pairs in (("CPU", cpu), ("wall", wall)):
        cpp_s, python_s = (sum(times) for times in zip(*pairs))
        middle = statistics.median(b / a for a, b in pairs)
        print(f"{name} time: C++ {cpp_s:.2f} s, Python {python_s:.2f} s; ratio of the sums {python_s / cpp_s:.4f}, "
              f"median over bins {middle:.4f}")


if __name__ == "__main__":
    main()
