//! Every text of the window, in English.

use crate::app::{Latency, PointerLatency, START_STAGES, StartStage, StartTimes};
use crate::opening::Remedy;
use crate::tools::ToolStrength;
use pliant_editor::{Gesture, LengthUnit, Substance};
use pliant_engine::session::{EventKind, WarningCode};
use std::fmt::Display;
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
/// Undo before any stroke.
pub const NOTHING_TO_UNDO: &str =
    "There is nothing to take back: the model is as it was opened, or as the last Apply has left it.";
/// Redo where nothing was taken back.
pub const NOTHING_TO_REDO: &str =
    "There is nothing to make again: no stroke was taken back, or another one was made since.";
/// Heading of the list of strokes.
pub const HISTORY: &str = "History";
/// The first entry of the list of strokes.
pub const AS_OPENED: &str = "as opened";
/// Heading of the reference image.
pub const REFERENCE: &str = "Reference";
/// Asks for a reference image.
pub const OPEN_REFERENCE: &str = "Reference image...";
/// See [`OPEN_REFERENCE`]. `takes_drops`: whether the window is told of files that are dropped on it.
pub fn reference_hint(takes_drops: bool) -> &'static str {
    match takes_drops {
        true => "A PNG or JPEG behind the model, which may also be dropped on the window.",
        false => "A PNG or JPEG behind the model.",
    }
}

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
/// What has happened in the session, for people: what it is and what to do in the window, and in brackets what the engine says where that tells more, as where it is.
/// `is_scene`: the bodies are those of a scene file, whose keys the engine names.
pub fn news(kind: EventKind, text: &str, is_scene: bool) -> String {
    let sentence = match kind {
        EventKind::GripLost => {
            "The hand let go, for it pulled with more than it can. Draw more slowly, or make the material softer."
        }
        EventKind::CutRefused => {
            "A part of the line could not be cut, for the faces there would become splinters or cross each other. Draw it again, a little beside."
        }
        EventKind::CutAgain => {
            "The line goes along an earlier cut, where nothing is left to cut. Draw it farther beside, or across."
        }
        EventKind::NotKept => {
            "The shape was not kept and springs back: the hand had let go, or the model is torn there or was folded through itself. Pull less far, or more slowly."
        }
        EventKind::Repaired => {
            "The model was folded through itself in a few places when its shape was kept. They were smoothed; Ctrl+Z takes the stroke back."
        }
        EventKind::FoldsLeft => {
            "The surface is folded onto itself in a few places, and was kept so. Smooth them with Shift, or take the stroke back with Ctrl+Z."
        }
        EventKind::Welded if !is_scene => {
            "Borders that lie together were joined, so the model holds together there. To have them apart, clear \"Join borders that lie together\" under Material and press Apply."
        }
        // It comes in many steps, each with numbers of its own.
        EventKind::NotConverged => {
            "A step was not solved to its tolerance, so what moves may be a little off. A softer material or a longer step helps."
        }
        EventKind::CutHeld => return with_details("The cut has not parted the model. Draw the line again.", text),
        EventKind::SplitRefused => return with_details(NOT_SPLIT, text),
        EventKind::Quarantine => {
            return with_details("The model stands still from now on. Ctrl+Z takes the stroke back.", text);
        }
        _ => text,
    };
    sentence.to_owned()
}

/// A stroke of a pressure under which the surface hardly gave way.
pub const FAINT_STROKE: &str = "The surface hardly gave way to this pressure. Make Strength or the tool larger (keys = and ]), or make the material softer.";

/// A body that is not split.
const NOT_SPLIT: &str = "The model was not split. A cut parts it that goes right through, from beside it to beside it.";

fn with_details(sentence: &str, details: &str) -> String {
    format!("{sentence} ({details})")
}

/// A warning of the session, for people: what to do in the window. `message` is that of the engine, which names keys of a scene file.
pub fn warning(code: WarningCode, message: &str, is_scene: bool) -> &str {
    match code {
        WarningCode::NoForce => "A stroke has met nothing. Begin it on the model.",
        WarningCode::CutsNothing => {
            "A line has cut nothing. Draw it across the model, from beside it to beside it; Cut depth says how far behind it the blade reaches."
        }
        WarningCode::ChangesNothing => {
            "A stroke has changed nothing of the model. Make the tool larger or hold it longer."
        }
        WarningCode::MovesNoVertex if !is_scene => {
            "A touch is felt and not seen, for the faces are larger than the tool. Choose \"Divide large faces\" under Material and press Apply, or make the tool larger."
        }
        WarningCode::SmallRadius => {
            "The tool is smaller than the cells of the grid and acts as if it were larger. Make it larger, or choose a higher grid level."
        }
        WarningCode::OpenBody if !is_scene => {
            "Parts of the model are not closed. A cut goes through them as through paper, without a face inside."
        }
        WarningCode::CoincidentBorders if !is_scene => {
            "Borders lie together and are not joined, so the model is in pieces there. Tick \"Join borders that lie together\" under Material and press Apply."
        }
        _ => message,
    }
}

/// After the first cut that was mirrored.
pub const MIRRORED_CUT: &str = "The cut was made on both sides. The faces and vertices that it has added have no mirror images: strokes on both sides move them nearly \
    alike, and all others exactly alike.";
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
/// A change of the stiffness in the list of strokes.
pub const HISTORY_STIFFNESS: &str = "stiffness";
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
/// Axes of the scene.
pub const AXES: [&str; 3] = ["X", "Y", "Z"];
/// Name of the button that mirrors strokes along an axis.
pub fn mirror_along(axis: &str) -> String {
    format!("mirror along {axis}")
}
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
/// Joins vertices of borders that lie at one place.
pub const WELD: &str = "Join borders that lie together";
/// See [`WELD`].
pub const WELD_HINT: &str = "Programs write a vertex twice where patches or texture charts end; such a model falls apart when it is touched. The lines of the saved file stay as they are.";

/// How many vertices lie where others do.
pub fn welded_vertices(count: usize) -> String {
    format!("{count} vertices")
}

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
/// Where a window has nothing to draw with.
pub const NO_CONTEXT: &str = "the window has no OpenGL context";
/// Why a window that was opened to ask for its renderer ends; nobody reads it.
pub const ONLY_ASKED: &str = "the renderer is known";

/// Where a window cannot be opened, and why.
pub fn no_window(why: &dyn Display) -> String {
    format!("the window cannot be opened: {why}")
}
/// Gauge of the time until the model was on screen.
pub const FIRST_PICTURE: &str = "first picture";
/// Gauge of the time from a motion of the pointer to the picture that shows it.
pub const TO_SCREEN: &str = "to screen";
/// Where nothing has been measured yet.
pub const NOT_YET: &str = "not yet";

/// A time in seconds.
pub fn seconds(seconds: f64) -> String {
    format!("{seconds:.2} s")
}

/// The median of a latency, in frames and milliseconds.
pub fn latency(latency: &Latency) -> String {
    let Latency { frames, seconds } = latency;
    match frames.count {
        0 => NOT_YET.to_owned(),
        _ => format!("{:.0} frames, {:.0} ms", frames.median, 1e3 * seconds.median),
    }
}

/// How long the start took, for the terminal.
pub fn start_timings(times: &StartTimes) -> String {
    let name = |stage| match stage {
        StartStage::Window => "window",
        StartStage::FirstFrame => "first frame",
        StartStage::Opened => "model open",
        StartStage::ModelShown => "model on screen",
    };
    let stages = START_STAGES.iter().filter_map(|stage| Some(format!("{} {:.3} s", name(*stage), times.of(*stage)?)));
    format!("timings from the start: {}", stages.collect::<Vec<_>>().join(", "))
}

/// How soon the picture shows what the pointer does, for the terminal.
pub fn pointer_timings(pointer: &PointerLatency) -> String {
    let of = |name: &str, Latency { frames, seconds }: Latency| {
        let ms = [seconds.median, seconds.p99].map(|s| 1e3 * s);
        format!(
            "{name}: median {} frames, {:.1} ms, 99th percentile {} frames, {:.1} ms, of {}",
            frames.median, ms[0], frames.p99, ms[1], frames.count
        )
    };
    format!(
        "timings of strokes, from the frame that takes the event in: {}; {}",
        of("pointer to screen", pointer.motions()),
        of("press to contact on screen", pointer.contacts())
    )
}

/// Heading of the warnings.
pub const WARNINGS: &str = "Warnings";
/// Names of files, with commas between them.
fn names(paths: &[impl AsRef<Path>]) -> String {
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    paths.iter().map(|path| name(path.as_ref())).collect::<Vec<_>>().join(", ")
}

/// None of the files that were dropped on the window can be opened.
pub fn not_dropped(paths: &[impl AsRef<Path>]) -> String {
    format!(
        "{}: cannot be opened; allowed are models (.obj, .msh, .vtk, .vtu), scenes (.toml) and reference images (.png, .jpg, .jpeg)",
        names(paths)
    )
}

/// None of what was dropped on the window is a file of this machine.
pub fn no_files_here(uris: &[String]) -> String {
    format!(
        "{}: not a file of this machine; copy it to a folder of this machine and drop it from there",
        uris.join(", ")
    )
}

/// Over the window while a file is dragged over it that would be opened.
pub fn drop_to_open(path: &Path) -> String {
    format!("Drop to open {}", names(&[path]))
}

/// Over the window while an image is dragged over it.
pub fn drop_as_reference(path: &Path) -> String {
    format!("Drop to put {} behind the model", names(&[path]))
}

/// An image that was dropped while no model is open.
pub fn image_without_model(path: &Path) -> String {
    format!("{}: a reference image stands behind a model; open a model first", names(&[path]))
}

/// Files that were dropped together with the one that is opened.
pub fn dropped_left_out(opened: &Path, left: &[&Path]) -> String {
    format!(
        "One file is opened at a time: {}. Left out: {}. MTL files and textures of a model are read from its folder.",
        names(&[opened]),
        names(left)
    )
}

/// Where a file that is to be opened is not there.
pub fn no_such_file(path: &Path) -> String {
    match path.is_dir() {
        true => format!("{}: a folder; allowed is a model or a scene", path.display()),
        false => format!("{}: there is no such file", path.display()),
    }
}

/// While a model is being opened.
pub const OPENING: &str = "Opening";
/// Without a model. `takes_drops`: whether the window is told of files that are dropped on it.
pub fn no_model(takes_drops: bool) -> &'static str {
    match takes_drops {
        true => "Open a model (Ctrl+O), or drop an OBJ file or a scene here.",
        false => "Open a model or a scene (Ctrl+O).",
    }
}

/// Closes a message.
pub const CLOSE: &str = "Close";
/// Answers of the question about unsaved strokes.
pub const UNSAVED: &str = "There are strokes that have not been saved.";
/// See [`UNSAVED`].
pub const DISCARD: &str = "Discard them";
/// Answers to [`recovery`].
pub const DISCARD_SHAPE: &str = "Discard it";
/// See [`UNSAVED`].
pub const CANCEL: &str = "Cancel";
/// Answer to [`replace`].
pub const REPLACE: &str = "Replace it";
/// Asks before another file is written over.
pub fn replace(path: &Path) -> String {
    format!("{} is there already.", path.display())
}
/// Asks for a file with the system's dialog.
pub const BROWSE: &str = "Browse...";
/// Label of the field of a file's path.
pub const PATH: &str = "File";
/// Button of the list of keys.
pub const KEYS_BUTTON: &str = "Keys (F1)";
/// Keys of the keyboard and buttons of the mouse with what they do, in groups. Tools have their keys beside them.
pub const KEYS: [(&str, &[(&str, &str)]); 4] = [
    (
        "Look around",
        &[
            ("Middle button", "turns the model"),
            ("Left button beside it", "turns it too"),
            ("Right button", "moves it; so does Shift and the middle one"),
            ("Wheel", "comes nearer to what is under the pointer"),
            ("F", "turns about what is under the pointer from now on"),
            ("Home", "shows all of the model"),
            ("W", "edges of the faces: over the model, alone, off"),
            ("O", "with or without perspective"),
        ],
    ),
    (
        "Work",
        &[
            ("Left button on the model", "the tool acts, until you let go"),
            ("1 to 0, and letters", "choose a tool: they stand beside it on the left"),
            ("Wheel in a stroke", "deeper, or nearer with what is held"),
            ("Shift", "smooths, whatever the tool"),
            ("Ctrl", "the opposite: deflates, shrinks, unpins, paints less"),
            ("[  ]", "smaller and larger tool"),
            ("-  =", "weaker and stronger"),
            (",  .", "softer and stiffer material, also while you hold it"),
            ("X  Y  Z", "strokes on both sides, along that axis"),
            ("K", "keeps the shape of a stroke, or lets it spring back"),
            ("B", "makes the part under the pointer a body of its own, after a cut"),
        ],
    ),
    (
        "Undo and files",
        &[
            ("Ctrl+Z", "takes the last stroke back"),
            ("Ctrl+Y, or Ctrl+Shift+Z", "makes it again"),
            ("Ctrl+S", "saves the model; nothing else writes it"),
            ("Ctrl+Shift+S", "saves it under another name"),
            ("Ctrl+O", "opens another one"),
            ("Ctrl+E", "exports GLB or STL"),
            ("Ctrl+Alt+S", "saves the session, as a scene to run again"),
            ("F12", "saves a picture"),
            ("Ctrl+Q", "quits"),
        ],
    ),
    (
        "Without a mouse",
        &[
            ("Arrows, faster with Shift", "move the pointer over the picture"),
            ("Space", "takes hold, and lets go"),
            ("Page up, Page down", "deeper in a stroke, nearer otherwise"),
            ("Alt and arrows", "turn the view"),
            ("Tab, Escape", "go through the controls, and back to the picture"),
        ],
    ),
];

/// What the tool of this name does with the pointer, in a line. `inverse`: the tool that it is with Ctrl.
pub fn tool_hint(name: &str, gesture: Gesture, inverse: Option<&str>) -> String {
    let how = match gesture {
        Gesture::Press => "hold the left button on the model and draw; the wheel goes deeper, Shift smooths",
        Gesture::Drag => "hold the left button on the model and draw it out; the wheel brings it nearer",
        Gesture::Slice => "draw a line from beside the model to beside it, and let go",
    };
    let opposite = inverse.map_or_else(String::new, |inverse| format!(", Ctrl: {inverse}"));
    format!("{name}: {how}{opposite}. Beside the model the left button turns it. Ctrl+Z takes a stroke back.")
}

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

/// What is wrong when simulation is slower than time, and what people can do. `taken_as`: solid or sheet; `None` for a scene.
pub fn slow(factor: f64, taken_as: Option<Substance>) -> String {
    let what = match taken_as {
        Some(Substance::Solid) => "A coarser grid, a softer material or a smaller tool makes it faster.",
        Some(Substance::Sheet) => "A longer step, a softer fabric or a model with fewer faces makes it faster.",
        None => "The scene says what it is made of: coarser grids, longer steps or softer materials make it faster.",
    };
    format!("Slow motion: {:.0} % of real time. {what}", 100.0 * factor)
}

/// The button that makes a slow simulation faster.
pub fn remedy(remedy: Remedy) -> String {
    match remedy {
        Remedy::CoarserGrid(level) => format!("Use a coarser grid, level {level}"),
        Remedy::LongerStep(dt) => format!("Use steps of {:.0} ms", 1e3 * dt),
    }
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

/// Heading of the question for the unit of a file.
pub const UNIT_HEADING: &str = "How large is it?";

/// The question for the unit of a file, whose longest edge has so many units.
pub fn unit_question(extent: f64) -> String {
    format!(
        "OBJ files say no unit, and forces and stiffness depend on the size. The longest edge of this model has {extent:.3} units. Choose what it is:"
    )
}

/// An answer to the question, which was guessed when the model was opened.
pub fn as_shown(answer: &str) -> String {
    format!("{answer}, as guessed")
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

/// Kinds of files in the dialogs of the system.
pub const MODELS_AND_SCENES: &str = "models and scenes";

/// See [`MODELS_AND_SCENES`].
pub const IMAGES: &str = "images";

/// What is wrong with the list of files that were opened last.
pub fn recent_problem(why: &dyn Display) -> String {
    format!("the list of recent files: {why}")
}

/// A picture was written.
pub fn picture_saved(path: &Path) -> String {
    format!("picture {}", path.display())
}

/// A model was written.
pub fn model_saved(path: &Path) -> String {
    format!("saved {}", path.display())
}

/// Gauges: simulated time over time on the wall.
pub const REAL_TIME: &str = "real time";

/// See [`REAL_TIME`].
pub const STEP: &str = "step";

/// See [`REAL_TIME`].
pub const TIME_STEP: &str = "time step";

/// See [`REAL_TIME`].
pub const HAPTIC_LOOP: &str = "haptic loop";

/// See [`REAL_TIME`].
pub const LATENESS: &str = "lateness";

/// See [`REAL_TIME`].
pub const SIMULATED: &str = "simulated";

/// See [`REAL_TIME`].
pub const MEMORY: &str = "memory";

/// Explains the plot of the force over the last seconds; `most` has its unit.
pub fn force_plot(seconds: f64, most: &str) -> String {
    format!("force on the hand over {seconds} s, up to {most}")
}

/// The force on the hand and its limit, both with their units.
pub fn force_of(force: &str, limit: &str) -> String {
    format!("force {force} of {limit}")
}

/// A time (s) in milliseconds.
pub fn milliseconds(seconds: f64) -> String {
    format!("{:.2} ms", seconds * 1e3)
}

/// A share, 1 for all.
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// A rate, Hz.
pub fn rate(hertz: f64) -> String {
    format!("{hertz:.0} Hz")
}

/// Median and 99th percentile of a time, s.
pub fn with_p99(median: f64, p99: f64) -> String {
    format!("{}, p99 {}", milliseconds(median), milliseconds(p99))
}

/// The latest beginning of a tick (s), and how many ticks were missed.
pub fn with_missed(lateness: f64, missed: u64) -> String {
    format!("{}, missed {missed}", milliseconds(lateness))
}

/// How much is simulated.
pub fn size_of(nodes: usize, elements: usize) -> String {
    format!("{nodes} nodes, {elements} elements")
}

/// Memory in megabytes.
pub fn megabytes(bytes: usize) -> String {
    format!("{:.0} MB", bytes as f64 / 1e6)
}

/// Why a measurement has failed.
pub const NOTHING_OPENED: &str = "nothing was opened";

/// See [`NOTHING_OPENED`].
pub const ENDED_EARLY: &str = "the session ended early";

/// Why nothing is simulated.
pub fn no_thread(why: &dyn Display) -> String {
    format!("no thread for the simulation: {why}")
}

/// How large the tool is, with its unit.
pub fn radius(length: &str) -> String {
    format!("radius {length}")
}

/// Why the present shape is not opened anew.
pub fn no_shape_folder(why: &dyn Display) -> String {
    format!("no folder for the present shape: {why}")
}

/// A line of the history: the number of the stroke, what it is called and when it was made, s.
pub fn stroke(number: u64, name: &str, time: f64) -> String {
    format!("{number}  {name} at {time:.0} s")
}

/// A unit of length, and how large the model is in it, with the unit that people would say it in.
pub fn unit_and_size(unit: LengthUnit, size: &str) -> String {
    let name = match unit {
        LengthUnit::Metre => "m",
        LengthUnit::Centimetre => "cm",
        LengthUnit::Millimetre => "mm",
        LengthUnit::Inch => "in",
    };
    format!("{name}: the model is {size}")
}

/// Units after the numbers of sliders.
pub const PASCAL: &str = " Pa";

/// See [`PASCAL`].
pub const KILOGRAM_PER_CUBIC_METRE: &str = " kg/m\u{b3}";

/// See [`PASCAL`].
pub const MILLISECOND: &str = " ms";

/// See [`PASCAL`].
pub const MILLIMETRE: &str = " mm";

/// Why the reference image of a model is not shown.
pub fn reference_unknown(why: &dyn Display) -> String {
    format!("the reference image is not known: {why}")
}

/// Why the reference image of a model will not come back.
pub fn reference_forgotten(why: &dyn Display) -> String {
    format!("the reference image is not remembered: {why}")
}

/// Name of the picture, for those who do not see it.
pub const PICTURE_OF_MODEL: &str = "picture of the model";

/// What is wrong with a texture.
pub fn texture_problem(path: &Path, why: &dyn Display) -> String {
    format!("texture {}: {why}", path.display())
}

/// Why an image cannot be read.
pub fn image_problem(why: &dyn Display) -> String {
    format!("{why}; allowed are PNG and JPEG")
}

/// What a texture is not.
pub const NO_IMAGE: &str = "neither PNG nor JPEG; allowed are these two";

/// A model that is too large for a GLB.
pub fn glb_too_large(path: &Path, length: u64) -> String {
    format!("{}: {length} bytes; allowed is 4 GiB, the most a GLB has", path.display())
}

/// What is wrong with a reference image.
pub fn reference_problem(path: &Path, why: &dyn Display) -> String {
    format!("reference image {}: {why}", path.display())
}

/// Why an image is not read.
pub fn no_reader(why: &dyn Display) -> String {
    format!("no thread to read it: {why}")
}

/// See [`no_reader`].
pub const READER_FAILED: &str = "reading it ended by an error in the program";

/// What to do about a file of the window's own that cannot be read.
pub fn to_mend(why: &dyn Display) -> String {
    format!("{why}; mend the file, or remove it to begin anew")
}

/// A scene in which there is nothing to do.
pub fn nothing_moves(path: &Path) -> String {
    format!("{}: nothing in it can be moved by a hand", path.display())
}

/// A model without a size.
pub fn one_point(path: &Path) -> String {
    format!("{}: its vertices all lie in one point", path.display())
}

/// Why a shape is not kept.
pub fn autosave_problem(why: &dyn Display) -> String {
    format!("autosave: {why}")
}

/// See [`autosave_problem`].
pub const AUTOSAVE_FAILED: &str = "autosave: its thread ended by an error in the program";

/// See [`autosave_problem`].
pub const NO_HOME: &str = "there is no home folder";

/// Why a session cannot be saved.
pub fn not_recorded(why: &str) -> String {
    format!("the session was not recorded: {why}")
}

/// A session that would be written over the scene it is of.
pub fn open_scene(path: &Path) -> String {
    format!("{}: the scene that is open; choose another name", path.display())
}

/// Why nothing moves any more.
pub const SIMULATION_FAILED: &str = "the simulation ended by an error in the program";

/// See [`SIMULATION_FAILED`].
pub const HAPTIC_THREAD_ENDED: &str = "the haptic thread has ended";

/// Why a scene is not opened.
pub const NOT_ONE_HAND: &str = "the scene has not one hand";

/// Why a model is open and nothing moves.
pub fn not_live(why: &dyn Display) -> String {
    format!("the live session cannot start: {why}")
}

/// See [`no_thread`].
pub const LAUNCHER_ENDED: &str = "the thread that starts others has ended";

/// The renderer of a driver, and its version of OpenGL.
pub fn renderer(renderer: &str, version: &str) -> String {
    format!("{renderer}, OpenGL {version}")
}

/// A version of OpenGL that is too old.
pub fn old_context(found: &str) -> String {
    format!("OpenGL {found}; allowed is 3.3 and newer")
}

/// What a driver says of a shader.
pub fn shader_problem(why: &str) -> String {
    format!("a program does not compile: {why}")
}

/// See [`shader_problem`].
pub fn link_problem(why: &str) -> String {
    format!("a program does not link: {why}")
}

/// A force (N) with so many decimals.
pub fn newtons(newtons: f64, decimals: usize) -> String {
    format!("{newtons:.decimals$} N")
}

/// A small force, N.
pub fn millinewtons(newtons: f64) -> String {
    format!("{:.1} mN", newtons * 1e3)
}

/// A force (N) that is hardly felt.
pub fn micronewtons(newtons: f64) -> String {
    format!("{:.1} \u{b5}N", newtons * 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Texts of the engine as a session gives them, with keys of scene files, numbers and names that the window does not show.
    #[test]
    fn what_the_engine_says_is_said_in_words_of_the_window() {
        let cut = "tool `hand` in body `model`: cut refused: a sliver would be left (smallest angle in degrees): triangle, 0.1412950734463446";
        let welded = "body `model`: 12 vertices on borders lie where others do and are taken as one with them; `weld = false` leaves the borders apart";
        let grip = "tool `hand`: it let go for the rest of its stroke: its force was over the `limit` of its edit";
        let kept = "tool `hand`: it had let go before its edit ended; allowed for `release = \"keep\"` is a force up to the `limit` of the edit";
        let repaired = "body `model`: 47 cells near [1.000, 2.000, 43.600] mm were inverted; their nodes were moved by at most 269.7 mm";
        let folded = "body `model`: the shape was kept with its surface folded at 3 edges, some of them near [1.000, 2.000, 43.600] mm";
        let of_kinds = [
            (EventKind::CutRefused, cut, "Draw it again"),
            (EventKind::Welded, welded, WELD),
            (EventKind::GripLost, grip, "more slowly"),
            (EventKind::NotKept, kept, "springs back"),
            (EventKind::Repaired, repaired, "smoothed"),
            (EventKind::FoldsLeft, folded, "kept so"),
        ];
        for (kind, text, says) in of_kinds {
            let said = news(kind, text, false);
            assert!(said.contains(says) && !said.contains(['`', '(']) && !said.contains("mm"), "{kind:?}: {said}");
        }
        let of_codes = [
            (WarningCode::MovesNoVertex, SUBDIVIDE),
            (WarningCode::CoincidentBorders, WELD),
            (WarningCode::CutsNothing, CUT_DEPTH),
            (WarningCode::NoForce, "Begin it on the model"),
        ];
        for (code, says) in of_codes {
            let said = warning(code, "give the body `subdivide = \"auto\"`, `weld = true`", false);
            assert!(said.contains(says) && !said.contains('`'), "{code:?}: {said}");
        }
        // A scene has no controls for these; its file is changed.
        assert_eq!(news(EventKind::Welded, welded, true), welded);
        assert_eq!(warning(WarningCode::MovesNoVertex, "give it `subdivide`", true), "give it `subdivide`");
        let place = news(EventKind::CutHeld, "parts still hold together near [1.000, 2.000, 3.000] mm", false);
        assert!(place.contains("near [1.000, 2.000, 3.000] mm"), "{place}");
    }
}
