// SPDX-License-Identifier: MIT
// A plan's pipelines and tables on a device, shared by any number of views, of which each may have a thread
// of its own: nothing in here changes after construction.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "penumbra/device.h"
#include "penumbra/error.h"
#include "penumbra/export.h"
#include "penumbra/plan.h"

namespace penumbra PENUMBRA_API {

struct ProgramOptions {
    // What pipeline_cache() gave before; data of another driver are ignored.
    std::span<const std::byte> pipeline_cache;
};

// Memory for the shared heaps of plans (CompileOptions::share_transients).
class TransientMemory;
uint64_t bytes_of(const TransientMemory& memory);

class ProgramState;

class Program {
  public:
    // Throws Failure. `plan` was compiled for this device (device_table(handles)).
    Program(const DeviceHandles& handles, std::shared_ptr<const Plan> plan,
            const ProgramOptions& options = {});
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    const DeviceHandles& handles() const;
    const Plan& plan() const;

    // What to keep for the next start.
    std::vector<std::byte> pipeline_cache() const;

    // Copies the tables to the device. Every view's first frame, and each of its reset frames, does so by
    // itself, so that it does not matter which one the queue sees first; a host with many views does it once,
    // before any of their frames, and says so (ViewOptions::tables_uploaded).
    void record_uploads(VkCommandBuffer cmd) const;

    // For views that run one after another on the queue (ViewOptions::transients): of this plan, or of any
    // that was compiled to share and needs no more. For several plans: make_transients(programs).
    std::shared_ptr<const TransientMemory> make_transients() const;

    uint64_t bytes() const;  // allocated for tables and for what stands for absent inputs

    const ProgramState& state() const { return *state_; }  // the views' own

  private:
    std::unique_ptr<const ProgramState> state_;
};

// The same for views of several programs, all of one device, none null: large enough for each.
std::shared_ptr<const TransientMemory> make_transients(std::span<const Program* const> programs);

}  // namespace penumbra
