/* SPDX-License-Identifier: MIT */
/* Where picture libraries put their bytes. */
#ifndef LCOR_CLI_SINK_H
#define LCOR_CLI_SINK_H

#include <OpenImageIO/filesystem.h>

#include <string>

namespace cli
{

/* An open file that remembers what the system refused, since some picture libraries do not look:
 * PNG writers take a full disk for success, JPEG writers end the program. */
class Sink : public OIIO::Filesystem::IOProxy
{
  public:
    /* `name` is for messages. Exit::permission or Exit::failed when it cannot be opened. */
    Sink(const std::string &path, const std::string &name);
    ~Sink() override;
    Sink(const Sink &) = delete;
    Sink &operator=(const Sink &) = delete;

    const char *proxytype() const override { return "lcor"; }
    bool seek(int64_t offset) override;
    size_t read(void *buffer, size_t size) override;
    size_t write(const void *buffer, size_t size) override;
    size_t size() const override;
    /* Throws what the system refused so far, if anything. */
    void check() const;

  private:
    const std::string name_;
    int file_, errno_ = 0;
};

} // namespace cli

#endif
