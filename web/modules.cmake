# SPDX-License-Identifier: Apache-2.0
# The front end in the order in which its modules are joined: a module behind those that it imports.
set(PANELCAL_WEB_MODULES
    base/dom.js
    base/words.js
    base/format.js
    base/colours.js
    base/columns.js
    base/leverage.js
    figures/pointed.js
    figures/chart.js
    figures/nights.js
    figures/panel_arrows.js
    figures/plane.js
    figures/field.js
    figures/leverage_map.js
    figures/surface_map.js
    views/job.js
    views/plan.js
    views/surface.js
    views/history.js
    views/night.js
    main.js)
