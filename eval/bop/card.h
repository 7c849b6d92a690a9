#pragma once

// What a data set was made from, beside it: dataset_card.json for programs, dataset_card.md for
// people.

#include <filesystem>
#include <map>
#include <string>

#include "eval/bop/make.h"

namespace pickbed::bop {

// All that the bytes of a scene depend on, as text: settings, sensor, meshes, views, split.
std::string IdentityOf(const ScenarioSpec& spec, const ObjectSet& objects,
                       const MakeOptions& options);

// The identity kept in a folder (dataset_settings.yaml), empty when there is none.
std::string ReadIdentity(const std::filesystem::path& out);
void WriteIdentity(const std::filesystem::path& out, const std::string& identity);

// With a hash of each scene's files (64-bit FNV-1a over names and bytes, in order of name).
void WriteCards(const ScenarioSpec& spec, const ObjectSet& objects, const MakeOptions& options,
                const std::string& identity);

// The parts by object id that a data set was made from, so that what was learned of them is known
// to hold for its models. Empty for a data set of other makers, and where models/ is no longer what
// the card states. Throws InputError for a broken card.
struct CardPart {
  std::string name;
  uint64_t mesh_hash = 0;
};
std::map<int, CardPart> PartsOfCard(const std::filesystem::path& root);

}  // namespace pickbed::bop
