#include "scenes/base/network_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(NetworkAddress, HostAndPortAreSeparated) {
  const scenes::NetworkAddress address = scenes::ParseNetworkAddress("gpu.lab:5555");
  EXPECT_EQ(address.host, "gpu.lab");
  EXPECT_EQ(address.port, 5555);
  EXPECT_EQ(scenes::ParseNetworkAddress("10.0.0.7:1").port, 1);
  EXPECT_EQ(scenes::ParseNetworkAddress("10.0.0.7:65535").port, 65535);
}

TEST(NetworkAddress, OtherTextsAreNamed) {
  for (const std::string text :
       {"", "localhost", "localhost:", ":5555", "localhost:0", "localhost:65536", "localhost:99999",
        "localhost:-1", "localhost:http", "localhost:5555x", "localhost: 5555",
        "localhost:99999999999999"}) {
    EXPECT_THAT(ErrorOf([&] { scenes::ParseNetworkAddress(text); }),
                HasSubstr("'" + text +
                          "' is no address; write host:port with a port from 1 to "
                          "65535"))
        << text;
  }
}

}  // namespace
}  // namespace pickbed::tests
