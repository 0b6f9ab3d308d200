# SPDX-License-Identifier: Apache-2.0
# The front end in the order in which its modules are joined: a module behind those that it imports.
set(PANELCAL_WEB_MODULES
    base/dom.js
    base/words.js
    base/format.js
    base/colours.js
    base/columns.js
    figures/place_index.js
    figures/map_colours.js
    figures/job_map.js
    figures/target_picture.js
    figures/arrows.js
    figures/job_charts.js
    views/job_targets.js
    views/job_fits.js
    views/job.js
    main.js)
