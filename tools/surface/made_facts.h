// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "calib/base/json/facts.h"
#include "tools/cli/provenance.h"
#include "tools/surface/text.h"

namespace panelcal::surface {

/// The head of what `panelcal surface COMMAND` states: docs/formats/surface.md,
/// share/schema/surface.schema.json.
facts::Json surface_envelope(std::string_view command);
/// [[what, value], ...]
facts::Json provenance_facts(const Provenance& provenance);
/// "source": of a height, as all documents have it.
std::string_view source_word(HeightSource source);

/// A map that was made: its figures, its probes, and what pictures are drawn of.
facts::Json made_facts(const MadeMap& made, const Provenance& provenance);
/// The part of it that one zone has.
facts::Json zone_facts(const MadeMap& made, std::size_t i_zone);

}  // namespace panelcal::surface
