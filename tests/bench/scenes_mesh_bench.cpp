// Benchmarks of reading, measuring and querying meshes. A ball of one level has 2^(2 level + 3)
// triangles.

#include <benchmark/benchmark.h>

#include <filesystem>
#include <string>

#include "scenes/base/files.h"
#include "scenes/geometry/mass_properties.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/mesh_io/mesh_import.h"
#include "scenes/mesh_io/mesh_io.h"
#include "tests/scenes/shapes.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

void BM_LoadMesh(benchmark::State& state) {
  const std::filesystem::path path =
      std::filesystem::path(PICKBED_SOURCE_DIR) / "assets/objects/pipe_tee/mesh.obj";
  for (auto _ : state) benchmark::DoNotOptimize(LoadMesh(path));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_LoadMesh)->Name("load_mesh/pipe_tee");

// Only the import, without the process and the cache of the next benchmark.
void BM_ImportMesh(benchmark::State& state) {
  const std::filesystem::path path = AssetsDir() / "objects" / "pipe_tee" / "mesh.obj";
  for (auto _ : state) benchmark::DoNotOptimize(ImportMesh(path, 1));
}
BENCHMARK(BM_ImportMesh)->Name("load_mesh/pipe_tee/import");

void BM_LoadUncachedMesh(benchmark::State& state) {
  // A copy at a new place is not in the cache.
  const TemporaryFolder folder;
  const std::string bytes = ReadFileBytes(AssetsDir() / "objects" / "pipe_tee" / "mesh.obj");
  int copy = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const std::filesystem::path path = folder.path() / std::to_string(copy++) / "mesh.obj";
    std::filesystem::create_directories(path.parent_path());
    WriteFileAtomically(path, bytes);
    state.ResumeTiming();
    benchmark::DoNotOptimize(LoadMesh(path));
  }
}
BENCHMARK(BM_LoadUncachedMesh)->Name("load_mesh/pipe_tee/uncached")->UseRealTime()->Iterations(50);

void BM_Diameter(benchmark::State& state) {
  const TriangleMesh ball = BallShape(0.1, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(Diameter(ball));
  state.SetItemsProcessed(state.iterations() * ball.vertices.size());
}
BENCHMARK(BM_Diameter)->Name("diameter/ball_level")->Arg(3)->Arg(5)->Arg(6);

void BM_MassProperties(benchmark::State& state) {
  const TriangleMesh ball = BallShape(0.1, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(UniformMassProperties(ball, 1));
  state.SetItemsProcessed(state.iterations() * ball.triangles.size());
}
BENCHMARK(BM_MassProperties)->Name("mass_properties/ball_level")->Arg(3)->Arg(6);

void BM_BuildQuery(benchmark::State& state) {
  const TriangleMesh ball = BallShape(0.1, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(MeshQuery(ball));
  state.SetItemsProcessed(state.iterations() * ball.triangles.size());
}
BENCHMARK(BM_BuildQuery)->Name("mesh_query/build/ball_level")->Arg(3)->Arg(6);

void BM_ClosestPoint(benchmark::State& state) {
  const MeshQuery query(BallShape(0.1, static_cast<int>(state.range(0))));
  Rng rng(1);
  for (auto _ : state) benchmark::DoNotOptimize(query.ClosestPoint(0.12 * rng.UnitVector()));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_ClosestPoint)->Name("mesh_query/closest_point/ball_level")->Arg(3)->Arg(6);

void BM_Raycast(benchmark::State& state) {
  const MeshQuery query(BallShape(0.1, static_cast<int>(state.range(0))));
  Rng rng(1);
  for (auto _ : state) {
    const Eigen::Vector3d origin = 0.2 * rng.UnitVector();
    const Eigen::Vector3d direction = (0.1 * rng.UnitVector() - origin).normalized();
    benchmark::DoNotOptimize(query.Raycast(origin, direction, 0, 1));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_Raycast)->Name("mesh_query/raycast/ball_level")->Arg(3)->Arg(6);

}  // namespace
}  // namespace pickbed::tests
