# SPDX-License-Identifier: Apache-2.0
"""All parameters of a picture: name, default, unit, meaning, realistic range, source.

A picture is a function of one such set of parameters and a seed. Sources: [cam] data sheets of
machine cameras (EMVA 1288); [pcb] IPC-6012, IPC-A-600 and suppliers' tables; [photo] two photographs
of real boards at about 40 px/mm; [guess] no source: judged by eye.
"""
import copy

TABLE = (
    # picture
    ("picture.width_px", 160, "px", "width", "160 to 640", ""),
    ("picture.height_px", 160, "px", "height", "160 to 480", ""),
    ("picture.supersample", 4, "1", "working samples per pixel along an axis, even", "4", ""),
    # target
    ("target.shape", "disc", "", "disc, hole, ring, square, diamond, cross, tag, triangle, or none", "", ""),
    ("target.unlike", "disc", "", "of a picture without a target: the shape that it is searched for", "", ""),
    ("target.size_px", 70.0, "px", "nominal: diameter, side, tip to tip, side of a tag's black frame", "30 to 120", ""),
    ("target.inner_px", 30.0, "px", "diameter of a ring's hole", "0.3 to 0.6 of size", "[pcb]"),
    ("target.inner_offset_px", [0.0, 0.0], "px", "of a ring's hole against its outline", "0 to 5", "[pcb] annular ring"),
    ("target.inner", "etched", "", "a ring's hole is etched or bored", "", ""),
    ("target.drill_px", 0.0, "px", "diameter of a bore in the target, which is no part of the artwork; 0: none", "0.2 to 0.5 of size", "[photo]"),
    ("target.drill_offset_px", [0.0, 0.0], "px", "that bore against the target's centre", "0 to 5", "[pcb]"),
    ("target.width_px", 14.0, "px", "width of a cross's bars", "0.12 to 0.3 of size", ""),
    ("target.angle_deg", 0.0, "deg", "turn of the target, from x towards y", "-3 to 3", ""),
    ("target.tag_id", 0, "", "AprilTag 36h11 id", "0 to 9", ""),
    ("target.polarity", "bright", "", "bright: metal on what is around; dark: etched out of metal", "", ""),
    ("target.centre_px", [79.5, 79.5], "px", "truth: picture coordinates of the artwork's centre", "", ""),
    # view
    ("view.kind", "telecentric", "", "telecentric or entocentric", "", ""),
    ("view.tilt_deg", 0.0, "deg", "angle between optical axis and the board's normal", "0 to 2, hard 5", "[guess]"),
    ("view.tilt_azimuth_deg", 0.0, "deg", "direction in which the board falls away", "0 to 360", ""),
    ("view.distance_px", 8000.0, "px", "from entrance pupil to board: 80 mm at 10 um/px", "4000 to 15000", "[cam]"),
    ("view.axis_px", [79.5, 79.5], "px", "picture coordinates of the optical axis", "within 1000 px", ""),
    # board
    ("board.style", "bare", "", "what is around a target: bare laminate, mask, copper", "", ""),
    ("board.mask_rgb_laminate", [0.012, 0.05, 0.012], "1", "mask over laminate, linear", "", "[photo]"),
    ("board.mask_rgb_copper", [0.018, 0.16, 0.03], "1", "mask over copper, linear", "", "[photo]"),
    ("board.laminate_rgb", [0.30, 0.27, 0.16], "1", "bare FR-4, linear", "0.08 to 0.35", "[guess]"),
    ("board.metal_rgb", [0.62, 0.42, 0.30], "1", "metal: copper; tin .40 .34 .32; gold .72 .55 .28", "", "[photo], [guess]"),
    ("board.weave", 0.10, "1", "contrast of the glass weave, part of laminate's radiance", "0.05 to 0.3", "[guess]"),
    ("board.weave_pitch_px", [46.0, 58.0], "px", "yarns (7628 to 1080 glass: 0.4 to 0.8 mm)", "35 to 80", "[pcb]"),
    ("board.weave_angle_deg", 0.0, "deg", "turn of the weave", "-3 to 3", ""),
    ("board.weave_mask", 0.4, "1", "part of the weave's contrast that mask lets through", "0 to 0.6", "[photo]"),
    ("board.mottle", 0.04, "1", "slow random unevenness of laminate and mask (rms)", "0.02 to 0.08", "[guess]"),
    ("board.opening_px", 5.0, "px", "mask opening larger than the pad, per side (50 um)", "0 to 10", "[pcb]"),
    ("board.opening_shift_px", [0.0, 0.0], "px", "mask registration", "0 to 8, hard 12", "[pcb] 75 um"),
    ("board.mask_ridge", 0.5, "1", "light on the mask's slope at copper edges, part of copper under mask", "0 to 1.5", "[photo]"),
    ("board.thickness_px", 160.0, "px", "depth of bores: 1.6 mm at 10 um/px", "40 to 320", "[pcb]"),
    # surface of metal
    ("surface.grain", 0.05, "1", "fine texture of metal, rms slope", "0.03 to 0.2", "[photo]"),
    ("surface.grain_px", 1.5, "px", "its correlation length", "0.7 to 5", "[photo]"),
    ("surface.grain_board", 0.03, "1", "fine texture of laminate and mask, rms part of radiance", "0.02 to 0.15", "[photo]"),
    ("surface.waviness", 0.04, "1", "slow slopes of metal, rms", "0.02 to 0.15", "[photo]"),
    ("surface.waviness_px", 25.0, "px", "their correlation length", "10 to 60", "[photo]"),
    ("surface.roughness", 0.30, "1", "unresolved: Beckmann alpha", "0.05 polished to 0.5 rough", "Torrance-Sparrow"),
    ("surface.brushed", 0.0, "1", "brush marks, rms slope across them", "0.1 to 0.4", "[photo]"),
    ("surface.brush_angle_deg", 30.0, "deg", "direction of the marks", "0 to 180", ""),
    ("surface.brush_px", [40.0, 1.0], "px", "their length and width", "", "[guess]"),
    ("surface.dome_deg", 0.0, "deg", "slope at the rim of a solder dome (HASL)", "10 to 45", "[photo]"),
    ("surface.dome_power", 1.5, "1", "slope grows as radius to this power; 1: a spherical cap", "1 to 4", "[guess]"),
    ("surface.dome_shift_px", [0.0, 0.0], "px", "crown of the dome against the pad's centre", "0 to 8", "[photo]"),
    ("surface.oxide", 0.0, "1", "part of metal under oxide", "0 to 0.6", "[guess]"),
    ("surface.oxide_depth", 0.6, "1", "light that oxide takes", "0.3 to 0.8", "[guess]"),
    ("surface.oxide_px", 12.0, "px", "size of oxide spots", "5 to 30", "[guess]"),
    ("surface.flux", 0.0, "1", "part of the picture under flux residue", "0 to 0.4", "[guess]"),
    ("surface.scratches", 0, "1", "number of scratches", "0 to 12", "[photo]"),
    ("surface.scratch_px", 1.2, "px", "their width", "0.5 to 2.5", "[photo]"),
    # outline of the target
    ("rim.band", 0.10, "1", "light of the etched flank, part of metal; negative: darker", "-0.6 to 0.8", "[photo]"),
    ("rim.band_px", 1.5, "px", "width of that flank inside the outline (35 um copper)", "0.5 to 3.5", "[pcb]"),
    ("rim.rough_px", 0.0, "px", "roughness of the outline, rms", "0.05 to 0.3, hard 0.6", "[pcb]"),
    ("rim.rough_corr_px", 4.0, "px", "its correlation length", "2 to 10", "[guess]"),
    ("rim.etch_px", 0.0, "px", "over-etching all round: the outline moves inwards", "-1 to 2", "[pcb] etch factor"),
    ("rim.etch_side_px", 0.0, "px", "over-etching on one side, at its middle", "0 to 3", "[guess]"),
    ("rim.etch_side_deg", 0.0, "deg", "azimuth of that side", "0 to 360", ""),
    ("rim.etch_side_width_deg", 70.0, "deg", "width (sigma) of that side", "40 to 120", "[guess]"),
    ("rim.torn", 0, "1", "number of torn places", "0 to 4", "[guess]"),
    ("rim.torn_px", 4.0, "px", "their depth", "1 to 8", "[guess]"),
    ("rim.debris", 0.0, "1", "part of the outline that lies under debris", "0 to 0.3", "[guess]"),
    ("rim.breakout_px", 0.0, "px", "how far a bore of breakout_diameter_px cuts into the outline", "0 to 20", "[pcb]"),
    ("rim.breakout_diameter_px", 30.0, "px", "its diameter", "", ""),
    ("rim.breakout_deg", 0.0, "deg", "its azimuth", "0 to 360", ""),
    # bores
    ("bore.wall_px", None, "px", "shift of the lower face; null: from tilt, view and thickness", "0 to 5", ""),
    ("bore.wall_azimuth_deg", 0.0, "deg", "where the lower face moves to, if wall_px is given", "0 to 360", ""),
    ("bore.wall", 0.25, "1", "light of the wall", "0.05 laminate to 0.8 plated", "[photo]"),
    ("bore.wall_plated", False, "", "plated: bright bands along the wall; else glass ends across it", "", "[photo]"),
    ("bore.bottom", 0.03, "1", "what lies below: 0.02 pit, 0.1 backing board, 0.6 white table", "0.01 to 0.6", "[photo]"),
    ("bore.lip", 0.0, "1", "light of the rounded rim of a plated bore, on the lamp's side", "0.3 to 1.5", "[photo]"),
    ("bore.lip_px", 1.5, "px", "its width (sigma)", "1 to 3", "[photo]"),
    ("bore.burr_px", 0.0, "px", "mean height of the burr that stands into the bore", "0.2 to 0.8, hard 1.5", "[pcb]"),
    ("bore.burr_side", 0.5, "1", "0: all round; 1: on one side only", "0 to 1", "[guess]"),
    ("bore.burr_deg", 0.0, "deg", "azimuth of that side", "0 to 360", ""),
    ("bore.burr_light", 0.5, "1", "light of the burr", "0.2 to 1.2", "[guess]"),
    ("bore.halo", 0.0, "1", "crazed, brighter laminate around a bore", "0 to 0.4", "[pcb] IPC-A-600"),
    ("bore.halo_px", 5.0, "px", "its width", "2 to 15", "[pcb]"),
    ("bore.pad_px", 0.0, "px", "diameter of a pad around a bore; 0: none", "", ""),
    ("bore.pad_shift_px", [0.0, 0.0], "px", "that pad against the bore", "0 to 10", "[pcb]"),
    # what else is on the board
    ("clutter.tracks", 0, "1", "tracks that end at the target", "0 to 4", "[photo]"),
    ("clutter.track_px", 14.0, "px", "their width", "8 to 30", "[photo]"),
    ("clutter.teardrop", 0.0, "1", "teardrop at each: length in radii of the target", "0 to 1.5", "[pcb]"),
    ("clutter.neighbours", 0, "1", "pads of other shapes", "0 to 6", "[photo]"),
    ("clutter.vias", 0, "1", "small vias", "0 to 8", "[photo]"),
    ("clutter.lines", 0, "1", "tracks that pass by", "0 to 6", "[photo]"),
    ("clutter.text", 0, "1", "letters of silk screen", "0 to 8", "[photo]"),
    ("clutter.plane", 0.0, "px", "copper all around, this far from the target; 0: none", "10 to 40", "[photo]"),
    ("clutter.clearance_px", 8.0, "px", "free space between target and clutter", "4 to 20", "[pcb]"),
    ("clutter.alike", 0, "1", "same shape, size wrong by 35 to 60 %, for pictures without a target", "0 to 3", ""),
    # dirt
    ("dirt.dust", 0, "1", "specks", "0 to 20", "[guess]"),
    ("dirt.fibres", 0, "1", "fibres", "0 to 3", "[guess]"),
    ("dirt.glints", 0, "1", "small mirrors that saturate", "0 to 10", "[photo]"),
    ("dirt.glint_level", 8.0, "1", "their radiance", "2 to 30", "[photo]"),
    ("dirt.lens_dust", 0, "1", "soft dark discs: dust near the sensor or on the lens", "0 to 3", "[cam]"),
    # lamp
    ("lamp.rgb", [0.33, 0.40, 0.27], "1", "part of each colour in a grey picture; red lamp: 1 0 0", "", "[guess]"),
    ("lamp.elevation_deg", 60.0, "deg", "of the ring lamp above the board", "30 to 75", "[cam]"),
    ("lamp.coaxial", 0.15, "1", "part of the light along the optical axis", "0 to 1", "[cam]"),
    ("lamp.diffuse", 0.35, "1", "part of the metal's light that does not mirror", "0.1 to 0.7", "[guess]"),
    ("lamp.uneven", 0.15, "1", "ring brighter on one side: 1 + uneven cos", "0 to 0.3, hard 0.9", "[photo]"),
    ("lamp.azimuth_deg", 0.0, "deg", "that side", "0 to 360", ""),
    ("lamp.gradient_per_100px", 0.05, "1", "linear change of the light over 100 px", "0 to 0.15, hard 0.5", "[photo]"),
    ("lamp.gradient_azimuth_deg", 0.0, "deg", "where it grows", "0 to 360", ""),
    ("lamp.vignetting_per_100px", 0.0, "1", "quadratic loss at 100 px from the target", "0 to 0.1", "[cam]"),
    # lens
    ("lens.cutoff_per_px", 0.85, "1/px", "pixel / (wavelength x f-number): 3.45 um, 0.58 um, f/7", "0.5 to 1.6", "Goodman"),
    ("lens.defocus_waves", 0.0, "waves", "defocus at the pupil's rim", "0 to 0.5, hard 1.5", "Goodman"),
    ("lens.spherical_waves", 0.03, "waves", "spherical aberration (Zernike)", "0 to 0.1", "[guess]"),
    ("lens.coma_waves", 0.03, "waves", "coma (Zernike); the shift of edges is taken out", "0 to 0.1", "[guess]"),
    ("lens.coma_azimuth_deg", 0.0, "deg", "its direction", "0 to 360", ""),
    ("lens.astigmatism_waves", 0.03, "waves", "astigmatism", "0 to 0.1", "[guess]"),
    ("lens.glare", 0.02, "1", "part of the light in a wide halo", "0 to 0.05", "[guess] ISO 9358"),
    ("lens.glare_px", 12.0, "px", "radius of the halo", "5 to 30", "[guess]"),
    ("lens.lateral_per_1000px", [0.0, 0.0, 0.0], "px", "shift of red, green, blue at 1000 px from the axis", "0 to 1, hard 2", "[cam]"),
    ("lens.axial_waves", [0.0, 0.0, 0.0], "waves", "defocus of red, green, blue", "0 to 0.3", "[guess]"),
    ("lens.chromatic", False, "", "render three colours even for a grey picture", "", ""),
    # motion
    ("motion.amplitude_px", 0.0, "px", "vibration when the exposure begins", "0 to 1, hard 4", "[guess]"),
    ("motion.azimuth_deg", 0.0, "deg", "its direction", "0 to 360", ""),
    ("motion.frequency_hz", 60.0, "Hz", "its frequency", "20 to 200", "[guess]"),
    ("motion.phase_deg", 0.0, "deg", "its phase at the beginning", "0 to 360", ""),
    ("motion.decay_ms", 20.0, "ms", "time to fall to 1/e", "5 to 100", "[guess]"),
    ("motion.exposure_ms", 10.0, "ms", "exposure", "1 to 30", "[cam]"),
    ("motion.drift_px", 0.0, "px", "steady motion during the exposure", "0 to 1", ""),
    # sensor
    ("sensor.level", 0.7, "1", "exposure: light of the target or around it, the brighter one, part of full well; without a target the 95 % quantile", "0.3 to 0.9", ""),
    ("sensor.full_well_e", 10000.0, "e-", "full well", "4000 to 30000", "[cam]"),
    ("sensor.shot", True, "", "photon noise", "", "EMVA 1288"),
    ("sensor.read_e", 6.0, "e-", "reading noise", "2 to 20", "[cam]"),
    ("sensor.prnu", 0.008, "1", "gain differs from pixel to pixel, rms", "0.003 to 0.015", "[cam]"),
    ("sensor.row_e", 0.0, "e-", "offset of each row, rms", "1 to 10, hard 60", "[cam]"),
    ("sensor.column_e", 0.0, "e-", "offset of each column, rms", "1 to 10, hard 60", "[cam]"),
    ("sensor.black", 0.01, "1", "black level, part of the range", "0 to 0.03", "[cam]"),
    ("sensor.fill_factor", 0.9, "1", "area of the pixel that sees light", "0.5 to 1", "[cam]"),
    ("sensor.bits", 8, "bit", "of the converter", "8, 10, 12, 16", "[cam]"),
    ("sensor.bayer", "", "", "mosaic: RG, GR, GB, BG; empty: a monochrome sensor", "", "[cam]"),
    ("sensor.white_balance", True, "", "colours are scaled so that white laminate is grey", "", ""),
    # processing and output
    ("process.demosaic", "bilinear", "", "bilinear, edge, or none: the mosaic is written as it is", "", ""),
    ("process.colour", False, "", "write RGB; else grey (luma of a mosaic)", "", ""),
    ("process.subtract_black", False, "", "take the black level off again", "", "[cam]"),
    ("process.saturation", 1.0, "1", "colours against their luma", "1 to 1.6", "[photo]"),
    ("process.denoise", "", "", "bilateral, nonlocal, or empty", "", ""),
    ("process.denoise_level", 0.03, "1", "likeness, part of the range", "0.02 to 0.06", "[guess]"),
    ("process.denoise_px", 2, "px", "reach", "2 to 4", "[guess]"),
    ("process.sharpen", 0.0, "1", "amount of unsharp mask", "0.3 to 1, hard 2", "[cam]"),
    ("process.sharpen_px", 1.0, "px", "its sigma", "0.7 to 1.5", "[cam]"),
    ("process.gamma", 1.0, "1", "exponent 1 / gamma of the output", "1 or 2.2", "[cam]"),
    ("process.jpeg", 0, "", "quality of a JPEG in between, 8 bits; 0: none", "75 to 95", "ITU-T T.81"),
    ("process.depth", 0, "bit", "8 or 16 bit file; 0: as many as the converter needs", "", ""),
    ("process.align", "low", "", "10 and 12 bit numbers in 16: low (as they are) or high (shifted up)", "", "GenICam Mono10, Mono12"),
)

NAMES = {row[0] for row in TABLE}


def defaults():
    """A new set of parameters, {"group": {"name": value}}."""
    out = {}
    for name, value, *_ in TABLE:
        group, key = name.split(".")
        out.setdefault(group, {})[key] = copy.deepcopy(value)
    return out


def put(parameters, name, value):
    """Sets "group.name"; refuses a name that does not exist, and names the nearest."""
    if name not in NAMES:
        import difflib
        near = difflib.get_close_matches(name, NAMES, 1, 0)
        raise SystemExit(f'render.py: unknown parameter: "{name}"; nearest: "{near[0]}"')
    group, key = name.split(".")
    parameters[group][key] = value


def merged(given):
    """Defaults with what a nested or flat ("group.name") dict gives."""
    out = defaults()
    for group, value in given.items():
        if "." in group:
            put(out, group, value)
        else:
            for key, inner in value.items():
                put(out, f"{group}.{key}", inner)
    return out


def changed(parameters):
    """Flat dict of what differs from the defaults: with the seed, enough to render a picture again."""
    return {name: parameters[name.split(".")[0]][name.split(".")[1]] for name, value, *_ in TABLE
            if parameters[name.split(".")[0]][name.split(".")[1]] != value}
