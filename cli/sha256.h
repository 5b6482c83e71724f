/* SPDX-License-Identifier: MIT */
#ifndef LCOR_CLI_SHA256_H
#define LCOR_CLI_SHA256_H

#include <string>

namespace cli
{

/* SHA-256 (FIPS 180-4) of bytes, as 64 hexadecimal digits: what sha256sum prints. */
std::string sha256(const std::string &bytes);

} // namespace cli

#endif
