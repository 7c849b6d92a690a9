#pragma once

// Id types, so that the numbers of an object, an instance and a bin cannot be confused.

#include <compare>
#include <concepts>

namespace pickbed::scenes {

// A number that names one kind of thing. It converts to int, for indices. An int converts to it
// only explicitly. Ids of different kinds can neither be converted nor compared.
template <typename Kind>
class Id {
 public:
  constexpr explicit Id(int number) : number_(number) {}
  template <typename Other>
  Id(const Id<Other>&) = delete;

  constexpr operator int() const { return number_; }
  constexpr Id& operator++() {
    ++number_;
    return *this;
  }

 private:
  int number_;
};

template <typename A, typename B>
requires(!std::same_as<A, B>) bool operator==(Id<A>, Id<B>) = delete;
template <typename A, typename B>
requires(!std::same_as<A, B>) std::strong_ordering operator<=>(Id<A>, Id<B>) = delete;

template <typename T>
inline constexpr bool kIsId = false;
template <typename Kind>
inline constexpr bool kIsId<Id<Kind>> = true;

// Index into the ObjectSet.
using ObjectId = Id<struct ObjectKind>;
inline constexpr ObjectId kAnyObject{-1};

// Number of a body in the bin. It is constant while others are picked.
using InstanceId = Id<struct InstanceKind>;
inline constexpr InstanceId kNoInstance{-1};

// Number of a bin. It is equal for the paired trials of several configurations. The random streams
// of a trial derive from it.
using BinIndex = Id<struct BinKind>;

}  // namespace pickbed::scenes
