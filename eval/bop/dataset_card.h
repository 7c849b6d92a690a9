#pragma once

// Record of what a simulated data set was made from: settings, meshes, seed and hashes. It is
// stored with the data set, as dataset_card.json for programs and dataset_card.md for people.

#include <filesystem>
#include <map>
#include <string>

#include "eval/bop/make_dataset.h"

namespace pickbed::eval {

// Returns, as text, everything that the bytes of a scene depend on: settings, sensor, meshes,
// views and split. Throws InputError if the sensor profile cannot be read.
std::string IdentityOf(const ScenarioSpec& spec, const ObjectSet& objects,
                       const MakeDatasetOptions& options);

// Reads and writes the identity of the data set in folder `out` (dataset_settings.yaml). Reading
// returns an empty text if the file does not exist.
std::string ReadIdentity(const std::filesystem::path& out);
// Writes the identity. Throws InputError if the folder cannot be written.
void WriteIdentity(const std::filesystem::path& out, const std::string& identity);

// Writes dataset_card.json and dataset_card.md into `options.out`. Both hold a hash of all scenes,
// and the JSON file one hash per scene: 64-bit FNV-1a over file names and bytes, sorted by name.
void WriteCards(const ScenarioSpec& spec, const ObjectSet& objects,
                const MakeDatasetOptions& options, const std::string& identity);

// Object of which the data set was made. The mesh hash shows whether a model trained on this object
// is valid for the data set.
struct CardObject {
  std::string name;
  uint64_t mesh_hash = 0;
};
// Returns the objects of the card by object id. The map is empty if the data set has no card or if
// models/ no longer matches the hash in the card. Throws InputError for a broken card.
std::map<int, CardObject> ObjectsOfCard(const std::filesystem::path& root);

}  // namespace pickbed::eval
