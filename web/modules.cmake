# SPDX-License-Identifier: Apache-2.0
# The front end in the order in which its modules are joined: a module behind those that it imports.
set(PANELCAL_WEB_MODULES
    base/dom.js
    base/words.js
    base/format.js
    base/colours.js
    figures/pointed.js
    figures/chart.js
    figures/nights.js
    figures/panel_arrows.js
    views/history.js
    views/job.js
    views/night.js
    main.js)
