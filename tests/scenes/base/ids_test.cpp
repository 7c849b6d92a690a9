#include "scenes/base/ids.h"

#include <gtest/gtest.h>

#include <concepts>
#include <string>
#include <type_traits>
#include <vector>

#include "scenes/base/ids_format.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

template <typename A, typename B>
concept CanEqual = requires(A a, B b) {
  a == b;
};
template <typename A, typename B>
concept CanDiffer = requires(A a, B b) {
  a != b;
};
template <typename A, typename B>
concept CanOrder = requires(A a, B b) {
  a < b;
};

// Whether an id of kind B can be used in any way where kind A is required.
template <typename A, typename B>
constexpr bool kMixes =
    std::is_convertible_v<B, A> || std::is_constructible_v<A, B> || std::is_assignable_v<A&, B> ||
    CanEqual<A, B> || CanDiffer<A, B> || CanOrder<A, B>;

static_assert(kMixes<ObjectId, ObjectId> && kMixes<InstanceId, InstanceId>);
static_assert(!kMixes<ObjectId, InstanceId> && !kMixes<InstanceId, ObjectId>);
static_assert(!kMixes<ObjectId, BinIndex> && !kMixes<BinIndex, ObjectId>);
static_assert(!kMixes<InstanceId, BinIndex> && !kMixes<BinIndex, InstanceId>);

static_assert(std::is_convertible_v<ObjectId, int>, "an id is an index");
static_assert(!std::is_convertible_v<int, ObjectId>, "an int becomes an id only explicitly");
static_assert(!std::is_assignable_v<ObjectId&, int>, "an int becomes an id only explicitly");
static_assert(std::is_constructible_v<ObjectId, int>);
static_assert(!std::is_default_constructible_v<ObjectId>, "each field gives its own default");
static_assert(sizeof(ObjectId) == sizeof(int));

static_assert(kIsId<BinIndex> && !kIsId<int>);

TEST(Ids, CompareWithTheirOwnKindAndWithNumbers) {
  EXPECT_EQ(InstanceId{3}, InstanceId{3});
  EXPECT_NE(InstanceId{3}, InstanceId{4});
  EXPECT_LT(InstanceId{3}, InstanceId{4});
  EXPECT_EQ(InstanceId{3}, 3);
  EXPECT_LT(kNoInstance, 0);
  EXPECT_LT(kAnyObject, 0);
}

TEST(Ids, CountAndIndex) {
  const std::vector<std::string> names{"box", "cup", "nut"};
  std::string all;
  for (ObjectId object{0}; object < static_cast<int>(names.size()); ++object) all += names[object];
  EXPECT_EQ(all, "boxcupnut");
}

TEST(Ids, AreFormattedAsTheirNumber) {
  EXPECT_EQ(fmt::format("{}", InstanceId{12}), "12");
  EXPECT_EQ(fmt::format("{:03}/{}", BinIndex{7}, kAnyObject), "007/-1");
}

}  // namespace
}  // namespace pickbed::tests
