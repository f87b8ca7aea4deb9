//! Every text of the window, in English.

use crate::tools::ToolStrength;
use std::path::Path;

/// Title of the window.
pub const TITLE: &str = "pliant";
/// The menu of models, sessions and pictures, and below what it holds.
pub const FILE: &str = "File";
/// See [`FILE`].
pub const OPEN: &str = "Open...";
/// The files that were opened last.
pub const OPEN_RECENT: &str = "Open recent";
/// See [`FILE`].
pub const SAVE: &str = "Save";
/// See [`FILE`].
pub const SAVE_AS: &str = "Save as...";
/// See [`FILE`]. Writes what was done by hand.
pub const SAVE_SESSION: &str = "Save session...";
/// See [`FILE`]. GLB, or STL by the ending of the name.
pub const EXPORT: &str = "Export...";
/// See [`FILE`].
pub const QUIT: &str = "Quit";
/// Writes what is seen as a file.
pub const PICTURE: &str = "Save a picture";
/// Takes the last stroke or change of layers back, or makes it again.
pub const UNDO: &str = "Undo";
/// See [`UNDO`].
pub const REDO: &str = "Redo";
/// Heading of the list of strokes.
pub const HISTORY: &str = "History";
/// The first entry of the list of strokes.
pub const AS_OPENED: &str = "as opened";
/// Heading of the reference image.
pub const REFERENCE: &str = "Reference";
/// Asks for a reference image.
pub const OPEN_REFERENCE: &str = "Reference image...";
/// See [`OPEN_REFERENCE`].
pub const REFERENCE_HINT: &str = "A PNG or JPEG behind the model, which may also be dropped on the window.";
/// Takes the reference image away.
pub const REMOVE: &str = "Remove";
/// Where the image stands.
pub const PLANE: &str = "Stands";
/// See [`PLANE`].
pub const PLANES: [&str; 4] = ["front", "side", "top", "behind, facing you"];
/// Controls of the image.
pub const REFERENCE_OPACITY: &str = "Image opacity";
/// See [`REFERENCE_OPACITY`].
pub const REFERENCE_HEIGHT: &str = "Height";
/// See [`REFERENCE_OPACITY`].
pub const REFERENCE_RIGHT: &str = "To the right";
/// See [`REFERENCE_OPACITY`].
pub const REFERENCE_UP: &str = "Up";
/// Makes each part of the bodies a body of its own.
pub const SPLIT: &str = "Split into parts";
/// See [`SPLIT`].
pub const SPLIT_HINT: &str =
    "After a cut right through: each part becomes a body of its own. Key B: the part under the pointer alone.";
/// A split in the list of strokes.
pub const HISTORY_SPLIT: &str = "split";
/// Name of a body that was split off.
pub const SPLIT_OFF: &str = "part";
/// Where the pointer is over no body.
pub const NOTHING_TO_SPLIT: &str = "Point at the part that is to become a body of its own.";
/// Heading of the sculpt layers.
pub const LAYERS: &str = "Layers";
/// Adds a layer.
pub const NEW_LAYER: &str = "New layer";
/// See [`NEW_LAYER`].
pub const NEW_LAYER_HINT: &str = "Strokes go into it from now on, if their shape is kept.";
/// What is below all layers.
pub const BASE: &str = "base";
/// See [`BASE`].
pub const BASE_HINT: &str = "Strokes go below all layers.";
/// Makes a layer a part of the base.
pub const MERGE: &str = "Merge";
/// See [`MERGE`].
pub const MERGE_HINT: &str = "The layer becomes a part of the base, as strong as it is now.";
/// Takes a layer away.
pub const DELETE: &str = "Delete";
/// See [`DELETE`].
pub const DELETE_HINT: &str = "Takes the layer away, with all that its strokes have done.";
/// Gives a layer another name.
pub const RENAME: &str = "Rename";
/// The box before a layer.
pub const LAYER_VISIBLE_HINT: &str = "Hides the layer, or shows it as strong as it was.";
/// A layer from before a cut.
pub const LAYER_FIXED: &str = "fixed by a cut";
/// See [`LAYER_FIXED`].
pub const FIXED_HINT: &str =
    "Something was cut or stitched since, and the new surface is not in the layer. Take that back, or merge the layer.";
/// Changes of the layers in the list of strokes.
pub const HISTORY_NEW_LAYER: &str = "new layer";
/// See [`HISTORY_NEW_LAYER`].
pub const HISTORY_RENAME_LAYER: &str = "rename layer";
/// See [`HISTORY_NEW_LAYER`].
pub const HISTORY_RECORD_LAYER: &str = "choose layer";
/// See [`HISTORY_NEW_LAYER`].
pub const HISTORY_LAYER_STRENGTH: &str = "layer strength";
/// See [`HISTORY_NEW_LAYER`].
pub const HISTORY_MERGE_LAYER: &str = "merge layer";
/// See [`HISTORY_NEW_LAYER`].
pub const HISTORY_DELETE_LAYER: &str = "delete layer";

/// Number of bodies, where there are several.
pub fn bodies(count: usize) -> String {
    format!("{count} bodies")
}

/// Name of a parameter of a material that is painted.
pub fn painted(param: &str) -> &str {
    if param == "young" { "stiffness" } else { param }
}

/// Name of a new layer.
pub fn layer_name(number: usize) -> String {
    format!("layer {number}")
}

/// Name of the box that shows a layer.
pub fn layer_visible(name: &str) -> String {
    format!("show {name}")
}

/// Name of the slider of a layer.
pub fn layer_strength(name: &str) -> String {
    format!("strength of {name}")
}

/// What a layer does, and what a click on its name does.
pub fn layer_hint(vertices: usize) -> String {
    format!("moves {vertices} vertices; a click: strokes go into it, at full strength")
}

/// Heading of the tools.
pub const TOOLS: &str = "Tools";
/// Sliders of the tool.
pub const SIZE: &str = "Size";
/// See [`SIZE`].
pub const STRENGTH: &str = "Strength";
/// How the effect of a tool decreases towards the outer ring.
pub const FALLOFF: &str = "Falloff";
/// The falloffs, in the order of the engine's list.
pub const FALLOFFS: [&str; 6] = ["smooth", "sphere", "root", "sharp", "linear", "constant"];
/// What the slider of the strength does.
pub fn strength_hint(strength: ToolStrength) -> &'static str {
    match strength {
        ToolStrength::Depth => "How deep it presses, in radii of the tool.",
        ToolStrength::Brush => "How strong it acts, over a new tool. It acts within the outer ring.",
        ToolStrength::Fixed => "",
    }
}
/// See [`SIZE`].
pub const CUT_DEPTH: &str = "Cut depth";
/// Which parameter of the material the tool paints.
pub const PAINTS: &str = "Paints";
/// See [`PAINTS`].
pub const PAINT_HINT: &str = "Four times as much; with Ctrl a quarter.";
/// Where no material has a parameter that may be painted.
pub const NOTHING_TO_PAINT: &str = "The material lets no parameter vary over a body, so there is nothing to paint.";
/// Where a body is neither cut nor stitched.
pub fn undivided(tool: &str) -> String {
    format!("\"{tool}\" does nothing here: a body is a tetrahedral mesh, which is neither cut nor stitched.")
}
/// What becomes of a stroke.
pub const KEEP: &str = "Keep the shape";
/// See [`KEEP`].
pub const SPRING_BACK: &str = "Spring back";
/// Label of what has the hand.
pub const HAND: &str = "Hand";
/// The pointer, where it has the hand.
pub const POINTER: &str = "mouse";
/// Label of the share of the force that a device renders.
pub const FORCE_SHARE: &str = "Force";
/// See [`FORCE_SHARE`].
pub const FORCE_SHARE_HINT: &str = "Share of the force that the device can render without trembling.";
/// Label of the planes of symmetry.
pub const SYMMETRY: &str = "Symmetry";
/// Without a plane of symmetry.
pub const OFF: &str = "off";
/// Axes of the scene.
pub const AXES: [&str; 3] = ["X", "Y", "Z"];
/// Names of the directions one may look from, for those who do not see them.
pub const LOOK_FROM: [[&str; 2]; 3] =
    [["look from +X", "look from -X"], ["look from +Y", "look from -Y"], ["look from +Z", "look from -Z"]];
/// Opens the shape of a session that has ended without closing.
pub const RECOVER: &str = "Open its shape";
/// Heading of the material.
pub const MATERIAL: &str = "Material";
/// Controls of the material.
pub const PRESET: &str = "Preset";
/// See [`PRESET`].
pub const STIFFNESS: &str = "Stiffness";
/// Slider of the stiffness of what has no Young's modulus of its own: a fabric, or the bodies of a scene.
pub const STIFFNESS_FACTOR: &str = "Stiffness";
/// What the sliders of stiffness do.
pub const STIFFNESS_HINT: &str = "Changes while you hold it, keys , and . too. The force on the hand does not jump.";
/// See [`PRESET`].
pub const DENSITY: &str = "Density";
/// See [`PRESET`].
pub const DAMPING: &str = "Damping time";
/// See [`PRESET`].
pub const FABRIC: &str = "Fabric";
/// See [`PRESET`].
pub const LEVEL: &str = "Grid level";
/// Whether large faces are divided.
pub const SUBDIVIDE: &str = "Divide large faces";
/// See [`SUBDIVIDE`].
pub const SUBDIVIDE_HINT: &str =
    "Divides every face into four, as often as it takes for a dent to show. The saved model has the divided faces.";
/// See [`PRESET`].
pub const UNIT: &str = "Unit of the file";
/// Solid or sheet.
pub const TAKEN_AS: &str = "Taken as";
/// See [`TAKEN_AS`].
pub const SOLID: &str = "solid";
/// See [`TAKEN_AS`].
pub const SHEET: &str = "sheet";
/// Opens the present shape with the chosen material.
pub const APPLY: &str = "Apply";
/// What applying does.
pub const APPLY_HINT: &str = "Goes on with the present shape at rest in this material. The history begins anew.";
/// Why the material of a scene is not changed here.
pub const SCENE_MATERIAL: &str = "The scene says what its bodies are made of.";
/// Heading of the view.
pub const VIEW: &str = "View";
/// Ways of shading.
pub const SHADINGS: [&str; 6] = ["studio", "clay", "metal", "wax", "facets", "displacement"];
/// Label of the ways of shading.
pub const SHADING: &str = "Shading";
/// Label of the ways to draw edges.
pub const WIREFRAME: &str = "Wireframe";
/// Ways to draw edges.
pub const WIREFRAMES: [&str; 3] = ["off", "over", "only"];
/// Label of the ways to show the pictures of two eyes.
pub const STEREO: &str = "Stereo";
/// Ways to show the pictures of two eyes.
pub const STEREOS: [&str; 3] = ["none", "red-cyan", "side by side"];
/// How opaque surfaces are drawn, 0 (not at all) to 1.
pub const OPACITY: &str = "Opacity";
/// Shows the scene without perspective.
pub const ORTHOGRAPHIC: &str = "Orthographic";
/// Which axis is up.
pub const Z_UP: &str = "Z up";
/// Colours and textures of the MTL files.
pub const FILE_COLOURS: &str = "Colours of the file";
/// See [`FILE_COLOURS`].
pub const FILE_COLOURS_HINT: &str = "Kd and map_Kd (PNG, JPEG) of the MTL file, with the shadings studio and facets.";
/// The grid on the ground.
pub const GROUND: &str = "Ground grid";
/// Draws the cells of the grid that take part in the simulation at the moment.
pub const CELLS: &str = "Simulated cells";
/// Looks at all of the model.
pub const FRAME_ALL: &str = "Look at all";
/// Changes to bright colours.
pub const LIGHT: &str = "Light";
/// Changes to dark colours.
pub const DARK: &str = "Dark";
/// Heading of the gauges.
pub const GAUGES: &str = "Gauges";
/// Heading of the warnings.
pub const WARNINGS: &str = "Warnings";
/// While a model is being opened.
pub const OPENING: &str = "Opening";
/// Without a model.
pub const NO_MODEL: &str = "Open a model (Ctrl+O), or drop an OBJ file or a scene here.";
/// Closes a message.
pub const CLOSE: &str = "Close";
/// Answers of the question about unsaved strokes.
pub const UNSAVED: &str = "There are strokes that have not been saved.";
/// See [`UNSAVED`].
pub const DISCARD: &str = "Discard them";
/// See [`UNSAVED`].
pub const CANCEL: &str = "Cancel";
/// Asks for a file with the system's dialog.
pub const BROWSE: &str = "Browse...";
/// Label of the field of a file's path.
pub const PATH: &str = "File";
/// The remedy of a slow simulation: half as many cells along each axis.
pub const COARSER: &str = "Use a coarser grid";
/// Keys, for the help at the lower edge.
pub const KEYS: &str = "Left: tool, beside the model turn   Middle: turn   Shift+middle or right: move   Wheel: nearer, in a stroke deeper   \
    F: focus   Home: all   G: grow   H: shrink   M: pin   P: paint   S: stitch   B: split off   [ ]: size   - =: strength   W: wireframe   , .: softer, stiffer   X: symmetry   Arrows, Space: pointer without a mouse   Ctrl+Z, Ctrl+Y: undo, redo";

/// A question about a session that has ended without closing.
pub fn recovery(path: &std::path::Path) -> String {
    format!("The last session with {} ended without closing. Its last shape was kept.", path.display())
}

/// A sentence for a model that was taken for a solid or a sheet.
pub fn substance_reason(openings: usize, is_sheet: bool) -> String {
    match (openings, is_sheet) {
        (0, _) => "It is closed, so it is filled.".into(),
        (n, true) => format!("It is open ({n} openings, the longest wider than the model), so it is cloth."),
        (n, false) => format!("It has {n} small holes, as scans have, and is filled."),
    }
}

/// What is wrong when other programs keep the processors from the simulation.
pub fn held_up(factor: f64) -> String {
    format!(
        "Slow motion: {:.0} % of real time, though steps are quick: other programs use the processors.",
        100.0 * factor
    )
}

/// What is wrong when simulation is slower than time.
pub fn slow(factor: f64) -> String {
    format!(
        "Slow motion: {:.0} % of real time. A coarser grid, a softer material or a smaller tool makes it faster.",
        100.0 * factor
    )
}

/// A session was written as a recording and a scene, and how it is done again. `gave_up`: a body was given up for taking too long, which only a replay
/// repeats.
pub fn session_saved(recording: &std::path::Path, scene: &std::path::Path, gave_up: bool) -> String {
    let (recording, scene) = (recording.display(), scene.display());
    if gave_up {
        return format!(
            "saved the session: pliant replay {recording}; a body was given up for taking too long, which a run does not repeat"
        );
    }
    format!("saved the session: pliant run {scene}, or pliant replay {recording} --verify")
}

/// A stiffness on its way: the present one and the one that is asked for, over that at the opening. `young`: Young's modulus (Pa) at the opening, if
/// there is one. `slew`: N/s, the largest change of the force on the hand, where it slows the change down.
pub fn stiffness_changes(now: f64, wanted: f64, young: Option<f64>, slew: Option<f64>) -> String {
    let value = |factor: f64| match young {
        Some(young) => format!("{:.1} kPa", 1e-3 * young * factor),
        None => format!("{factor:.2} x"),
    };
    let slowed = slew.map_or_else(String::new, |slew| format!(", slowly: the force changes by at most {slew:.3} N/s"));
    format!("Stiffness {}, going to {}{slowed}", value(now), value(wanted))
}

/// The question for the unit of a file, whose longest edge has so many units.
pub fn unit_question(extent: f64) -> String {
    format!("OBJ files say no unit. The longest edge of this model has {extent:.3} units. How large is it?")
}

/// What the model is drawn beside, and how long that is.
pub const HAND_BESIDE: &str = "a hand, 19 cm";

/// Tells of a device that is lost. `why`: what it returned, in words.
pub fn device_lost(name: &str, why: &str) -> String {
    format!(
        "The device \"{name}\" is lost: {why}. The mouse has the hand. Look at its cable, its power and its driver, then choose it again under Hand."
    )
}

/// Button of the list of messages.
pub fn messages(count: usize) -> String {
    format!("Messages ({count})")
}
/// Where nothing has happened yet.
pub const NO_MESSAGES: &str = "Nothing has happened yet.";

/// How long ago a message came.
pub fn ago(time: std::time::Duration) -> String {
    match time.as_secs() {
        0..60 => "less than a minute ago".to_owned(),
        60..120 => "a minute ago".to_owned(),
        seconds => format!("{} minutes ago", seconds / 60),
    }
}

/// Why a reference image is not seen.
pub fn reference_not_shown(path: &Path, [width, height]: [u32; 2], why: &str) -> String {
    format!("{}: {width} x {height} pixels cannot be shown: {why}. A smaller image may be.", path.display())
}

/// What a tetrahedral mesh is taken as.
pub const TETRAHEDRAL: &str =
    "A tetrahedral mesh: a solid on the elements of its file. Apply opens the file anew, without the strokes.";
/// Where the shape of a tetrahedral mesh is opened that is kept as a surface.
pub const TETRAHEDRA_LEFT: &str = "The shape that was kept is a surface, so it is simulated in a grid of cubes, and no longer on the tetrahedra of the file.";
/// Where a name asks for a format that is only read.
pub fn tetrahedra_not_written(path: &Path) -> String {
    format!(
        "{}: tetrahedral meshes are read and not written; allowed are .obj, .glb and .stl, which get the surface",
        path.display()
    )
}

/// How far the hand goes in the scene for a centimetre of the device.
pub fn device_scale(step: &str) -> String {
    format!("1 cm of the device is {step}")
}
