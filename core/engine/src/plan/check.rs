//! Checks of a parsed scene: names, ranges of numbers, keys that belong together.

use crate::body::PaintDepth;
use crate::edit::{Command, EditKind, KeyName, Strength};
use crate::scene::{
    Amount, BladeScene, BodyScene, DeviceScene, EditScene, Extent, FieldScene, FixedScene, IntegratorChoice, Length,
    ObstacleScene, ProbeScene, Scene, SceneError, SheetContact, Source, ToolScene, parse_quantity,
};
use pliant_mesh::TetMesh;
use std::ops::Range;
use toml::Spanned;

/// Number of buttons of a hand.
const BUTTONS: u32 = 32;
/// Longest simulated time, s, about 30 years: the clock of devices counts nanoseconds in 64 bits.
const MAX_SECONDS: f64 = 1e9;
/// Largest number of steps of a run.
const MAX_STEPS: f64 = 1e9;

/// Checks a scene.
///
/// # Errors
/// Returns the first error, with the value found and what is allowed.
pub(super) fn check(scene: &Scene, source: &Source) -> Result<(), SceneError> {
    let check = Check(source);
    check.time(scene)?;
    check.names("body", scene.body.iter().map(|b| &b.name))?;
    check.names("obstacle", scene.obstacle.iter().map(|o| &o.name))?;
    check.names("device", scene.device.iter().map(|d| &d.name))?;
    check.names("tool", scene.tool.iter().map(|t| &t.name))?;
    scene.body.iter().try_for_each(|body| check.body(body))?;
    scene.body.iter().try_for_each(|body| super::collisions::check(body, scene, source))?;
    scene.body.iter().filter_map(|body| body.friction.as_ref()).try_for_each(|friction| check.friction(friction))?;
    super::stitches::check(scene, source)?;
    scene.obstacle.iter().try_for_each(|obstacle| check.obstacle(obstacle, scene))?;
    scene.device.iter().try_for_each(|device| check.device(device))?;
    scene.tool.iter().try_for_each(|tool| check.tool(tool))?;
    scene.edit.iter().try_for_each(|edit| check.edit(edit))?;
    check.edits_of_tetrahedra(scene)?;
    scene.probe.iter().try_for_each(|probe| check.probe(probe, scene.time.duration.get_ref().si))?;
    match &scene.output.frames {
        Some(rate) => check.above(rate.get_ref().si, rate.span(), "frames", " Hz"),
        None => Ok(()),
    }
}

/// The `strength` of an edit in the SI unit of its kind; `None` if it is absent or the kind has none.
///
/// # Errors
/// Fails for a text with another unit and for a number that is not above 0.
pub(crate) fn strength(edit: &EditScene, kind: &dyn EditKind, source: &Source) -> Result<Option<f64>, SceneError> {
    let (Some(given), Some(Strength { unit, range, .. })) = (&edit.strength, kind.strength()) else { return Ok(None) };
    let value = match given.get_ref() {
        Amount::Number(value) => *value,
        Amount::Text(text) if unit.is_empty() => text.trim().parse().map_err(|_| {
            let text = format!("strength of a `{}`: `{text}` is not a number; a factor has no unit", kind.name());
            source.error(given.span(), text)
        })?,
        Amount::Text(text) => parse_quantity(text, unit)
            .map_err(|why| source.error(given.span(), format!("strength of a `{}`: {why}", kind.name())))?,
    };
    match range {
        Some([low, high]) if !(low..=high).contains(&value) => {
            let text = format!("strength of a `{}` is {value}; allowed is {low} to {high}", kind.name());
            Err(source.error(given.span(), text))
        }
        Some(_) => Ok(Some(value)),
        None => Check(source).above(value, given.span(), "strength", &format!(" {unit}")).map(|()| Some(value)),
    }
}

/// The `depth` of an edit.
///
/// # Errors
/// Fails for a text that is neither `through`, `surface` nor a length, and for a length that is not above 0.
pub(super) fn depth(edit: &EditScene, source: &Source) -> Result<PaintDepth, SceneError> {
    let Some(given) = &edit.depth else { return Ok(PaintDepth::Through) };
    let thickness = match given.get_ref() {
        Amount::Number(value) => *value,
        Amount::Text(text) if text == "through" => return Ok(PaintDepth::Through),
        Amount::Text(text) if text == "surface" => return Ok(PaintDepth::Layer(0.0)),
        Amount::Text(text) => parse_quantity(text, "m").map_err(|why| {
            let allowed = "allowed is \"through\", \"surface\" or the thickness of a layer";
            source.error(given.span(), format!("depth {text:?}: {allowed}; {why}"))
        })?,
    };
    Check(source).above(thickness, given.span(), "depth", " m").map(|()| PaintDepth::Layer(thickness))
}

/// Checks with the source for error messages.
pub(super) struct Check<'a>(&'a Source);

impl Check<'_> {
    /// An error at a span of the source.
    pub(super) fn wrong(&self, span: Range<usize>, text: impl Into<String>) -> Result<(), SceneError> {
        Err(self.0.error(span, text))
    }

    /// Checks that a value is finite and above 0.
    fn above(&self, value: f64, span: Range<usize>, what: &str, unit: &str) -> Result<(), SceneError> {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        self.wrong(span, format!("{what} is {value}{unit}; allowed is a number above 0"))
    }

    /// Checks that names are unique and can be used in names of files and CSV columns.
    fn names<'a>(&self, what: &str, names: impl Iterator<Item = &'a Spanned<String>>) -> Result<(), SceneError> {
        let mut known: Vec<&str> = Vec::new();
        for spanned in names {
            let name = spanned.get_ref().as_str();
            if name.is_empty() || name.contains(|c: char| c.is_control() || r#"/\,""#.contains(c)) {
                let text = format!("{what} {name:?}; allowed is a name without / \\ , \" and control characters");
                return self.wrong(spanned.span(), text);
            }
            if known.contains(&name) {
                return self
                    .wrong(spanned.span(), format!("{what} `{name}` is there twice; allowed is one of each name"));
            }
            known.push(name);
        }
        Ok(())
    }

    fn time(&self, scene: &Scene) -> Result<(), SceneError> {
        let (time, tolerance) = (&scene.time, &scene.solver.tolerance);
        let (dt, duration) = (time.dt.get_ref().si, time.duration.get_ref().si);
        self.above(dt, time.dt.span(), "dt", " s")?;
        self.above(duration, time.duration.span(), "duration", " s")?;
        self.above(time.patience.get_ref().si, time.patience.span(), "patience", " s")?;
        if let Some(sleep) = &time.sleep {
            self.above(sleep.get_ref().si, sleep.span(), "sleep", " m/s")?;
        }
        for (what, time) in [("dt", &time.dt), ("duration", &time.duration)] {
            if time.get_ref().si > MAX_SECONDS {
                let text = format!("{what} is {:e} s; allowed is {MAX_SECONDS:e} s at most", time.get_ref().si);
                return self.wrong(time.span(), text);
            }
        }
        if duration / dt > MAX_STEPS {
            let text = format!("dt is {dt:e} s, {:e} steps; allowed is {MAX_STEPS:e} steps at most", duration / dt);
            return self.wrong(time.dt.span(), text);
        }
        let most = *time.most_substeps.get_ref();
        for (what, count) in [("most-substeps", &time.most_substeps), ("iterations", &scene.solver.iterations)] {
            if *count.get_ref() == 0 {
                return self.wrong(count.span(), format!("{what} is 0; allowed is 1 or more"));
            }
        }
        if *time.substeps.get_ref() > most {
            let text = format!("substeps is {}; allowed is 0 to most-substeps, {most}", time.substeps.get_ref());
            return self.wrong(time.substeps.span(), text);
        }
        if !(0.0 < *tolerance.get_ref() && *tolerance.get_ref() < 1.0) {
            let text = format!("tolerance is {}; allowed is a number above 0 and below 1", tolerance.get_ref());
            return self.wrong(tolerance.span(), text);
        }
        let newton = &scene.solver.newton_tolerance;
        self.above(*newton.get_ref(), newton.span(), "newton-tolerance", "")?;
        if let Some(zero) = scene.solver.newton.as_ref().filter(|n| *n.get_ref() == 0) {
            return self.wrong(zero.span(), "newton is 0; allowed is 1 or more");
        }
        if scene.body.is_empty() { Err(self.0.whole("no [[body]]; a scene needs one at least")) } else { Ok(()) }
    }

    fn body(&self, body: &BodyScene) -> Result<(), SceneError> {
        match (&body.mesh, &body.shape) {
            (Some(mesh), Some(_)) => return self.wrong(mesh.span(), "`mesh` and `shape`; allowed is one of them"),
            (None, None) => {
                // A default name is not in the text; the material is.
                let span = [body.name.span(), body.material.plugin.span()].into_iter().find(|s| *s != (0..0));
                let text = format!("body `{}` has no model; allowed is one of `mesh` and `shape`", body.name.get_ref());
                return self.wrong(span.unwrap_or(0..0), text);
            }
            _ => {}
        }
        if let (Some(size), Some(_)) = (&body.size, &body.scale) {
            return self.wrong(size.span(), "`size` and `scale`; allowed is one of them");
        }
        if let Some(scale) = &body.scale {
            self.above(*scale.get_ref(), scale.span(), "scale", "")?;
        }
        if let Some(size) = &body.size {
            self.above(size.get_ref().si, size.span(), "size", " m")?;
        }
        if let Some(radius) = &body.grid.get_ref().radius {
            self.above(radius.get_ref().si, radius.span(), "radius of the region", " m")?;
        }
        self.above(
            body.grid.get_ref().relaxation.get_ref().si,
            body.grid.get_ref().relaxation.span(),
            "relaxation",
            " s",
        )?;
        if body.is_tetrahedral() {
            self.tetrahedra(body)?;
        }
        let region = body.extent();
        body.field.iter().try_for_each(|field| self.field(field))?;
        self.fibres(body)?;
        body.fixed.iter().try_for_each(|fixed| self.fixed(fixed, region))
    }

    /// Checks that a body of tetrahedra has no keys of other bodies.
    fn tetrahedra(&self, body: &BodyScene) -> Result<(), SceneError> {
        let mesh = body.mesh.as_ref().map_or("", |mesh| mesh.get_ref());
        let others = [
            ("sheet", body.sheet.as_ref().map(Spanned::span), "a sheet is an OBJ file"),
            ("subdivide", body.subdivide.as_ref().map(Spanned::span), "refine the mesh where it was made"),
            (
                "grid",
                Some(body.grid.span()).filter(|span| *span != (0..0)),
                "it is simulated as it is, as a whole and without a grid",
            ),
            (
                "stitch",
                body.stitch.first().map(|_| body.mesh.as_ref().map_or(0..0, Spanned::span)),
                "only sheets are sewn",
            ),
        ];
        match others.into_iter().find_map(|(key, span, why)| Some((key, span?, why))) {
            Some((key, span, why)) => self.wrong(
                span,
                format!("`{key}` of body `{}`, a tetrahedral mesh ({mesh}): {why}; leave it out", body.name.get_ref()),
            ),
            None => Ok(()),
        }
    }

    /// Checks that no edit cuts or stitches where there is a body of tetrahedra, which would not follow.
    fn edits_of_tetrahedra(&self, scene: &Scene) -> Result<(), SceneError> {
        let Some(body) = scene.body.iter().find(|body| body.is_tetrahedral()) else { return Ok(()) };
        for edit in &scene.edit {
            if let Command::Tool(kind) = self.command(edit)?
                && (kind.cuts() || kind.name() == "stitch")
            {
                let text = format!(
                    "edit kind `{}` where body `{}` is a tetrahedral mesh, which is neither cut nor stitched; allowed is another kind, or the body's surface as an OBJ file",
                    kind.name(),
                    body.name.get_ref()
                );
                return self.wrong(edit.kind.span(), text);
            }
        }
        Ok(())
    }

    /// Checks that a field has exactly one way to give its factors.
    fn field(&self, spanned: &Spanned<FieldScene>) -> Result<(), SceneError> {
        let (field, span) = (spanned.get_ref(), spanned.span());
        let given = [
            field.box_.as_ref().map(|_| "`box`"),
            field.ball.as_ref().map(|_| "`ball`"),
            field.radius.as_ref().map(|_| "`radius`"),
            field.group.as_ref().map(|_| "`group`"),
            field.colour.as_ref().map(|_| "`colour`"),
            field.csv.as_ref().map(|_| "`csv`"),
            field.texture.as_ref().map(|_| "`texture`"),
            field.data.as_ref().map(|_| "`data`"),
            field.unit.as_ref().map(|_| "`unit`"),
            field.range.as_ref().map(|_| "`range`"),
            field.factor.as_ref().map(|_| "`factor`"),
        ];
        let found: Vec<&str> = given.into_iter().flatten().collect();
        let is_one = matches!(
            found[..],
            ["`box`", "`factor`"]
                | ["`ball`", "`radius`", "`factor`"]
                | ["`group`", "`factor`"]
                | ["`colour`"]
                | ["`colour`", "`range`"]
                | ["`csv`"]
                | ["`texture`"]
                | ["`texture`", "`range`"]
                | ["`data`"]
                | ["`data`", "`unit`"]
        );
        if !is_one {
            let found = if found.is_empty() { "no place".into() } else { found.join(" and ") };
            let text = format!(
                "`field` has {found}; allowed is `factor` with `box`, with `ball` and `radius` or with `group`, or `colour` or `texture` with \
                 or without `range`, or `csv`, or `data` with or without `unit`"
            );
            return self.wrong(span, text);
        }
        self.place(field.box_.as_ref(), field.radius.as_ref(), span)
    }

    /// Checks the corners of a box and the radius of a ball.
    pub(super) fn place(
        &self,
        corners: Option<&[[Length; 3]; 2]>,
        radius: Option<&Length>,
        span: Range<usize>,
    ) -> Result<(), SceneError> {
        if let Some([min, max]) = corners
            && let Some(axis) = (0..3).find(|&i| min[i].si > max[i].si)
        {
            let text =
                format!("`box` goes from {} m to {} m; allowed is the least corner first", min[axis].si, max[axis].si);
            return self.wrong(span, text);
        }
        radius.map_or(Ok(()), |radius| self.above(radius.si, span, "radius", " m"))
    }

    fn fixed(&self, spanned: &Spanned<FixedScene>, region: Extent) -> Result<(), SceneError> {
        let (fixed, span) = (spanned.get_ref(), spanned.span());
        let found: Vec<&str> = [
            fixed.box_.as_ref().map(|_| "`box`"),
            fixed.ball.as_ref().map(|_| "`ball`"),
            fixed.radius.as_ref().map(|_| "`radius`"),
            fixed.group.as_ref().map(|_| "`group`"),
            fixed.nodes.as_ref().map(|_| "`nodes`"),
        ]
        .into_iter()
        .flatten()
        .collect();
        if !matches!(found[..], ["`box`"] | ["`ball`", "`radius`"] | ["`group`"] | ["`nodes`"]) {
            let found = if found.is_empty() { "no place".into() } else { found.join(" and ") };
            let text = format!("`fixed` has {found}; allowed is `box`, `ball` and `radius`, `group`, or `nodes`");
            return self.wrong(span, text);
        }
        self.place(fixed.box_.as_ref(), fixed.radius.as_ref(), span.clone())?;
        if fixed.nodes.is_some() && region == Extent::Local {
            return self
                .wrong(span, "`nodes` of a local region have no lasting numbers; allowed is `box`, `ball` or `group`");
        }
        self.path(&fixed.path, "a `fixed`", span)
    }

    /// Checks that the rows of a path are finite and in the order of time.
    fn path(&self, path: &[[f64; 4]], of: &str, span: Range<usize>) -> Result<(), SceneError> {
        let wrong = |(i, row): (usize, &[f64; 4])| {
            let rises = i == 0 || path[i - 1][0] < row[0];
            !(rises && row.iter().all(|c| c.is_finite()))
        };
        match path.iter().enumerate().find(|row| wrong(*row)) {
            Some((i, row)) => self.wrong(
                span,
                format!("row {} of the path of {of} is {row:?}; allowed is finite numbers, times rising", i + 1),
            ),
            None => Ok(()),
        }
    }

    fn obstacle(&self, obstacle: &ObstacleScene, scene: &Scene) -> Result<(), SceneError> {
        let (name, span) = (obstacle.name.get_ref(), obstacle.name.span());
        if let Some(mesh) = obstacle.mesh.as_ref().filter(|mesh| TetMesh::is_name(mesh.get_ref())) {
            let text =
                format!("obstacle `{name}` of a tetrahedral mesh; allowed is an OBJ file: an obstacle is a surface");
            return self.wrong(mesh.span(), text);
        }
        match (&obstacle.mesh, &obstacle.shape) {
            (Some(mesh), Some(_)) => return self.wrong(mesh.span(), "`mesh` and `shape`; allowed is one of them"),
            (None, None) => {
                let text = format!("obstacle `{name}` has no surface; allowed is one of `mesh` and `shape`");
                return self.wrong(span, text);
            }
            (None, Some(_)) => {
                let of_mesh = [
                    ("size", obstacle.size.as_ref().map(Spanned::span)),
                    ("scale", obstacle.scale.as_ref().map(Spanned::span)),
                ];
                if let Some((key, Some(span))) = of_mesh.into_iter().find(|(_, span)| span.is_some()) {
                    return self
                        .wrong(span, format!("`{key}` of obstacle `{name}` is for a `mesh`, and it has a `shape`"));
                }
            }
            (Some(_), None) => {}
        }
        if let (Some(size), Some(_)) = (&obstacle.size, &obstacle.scale) {
            return self.wrong(size.span(), "`size` and `scale`; allowed is one of them");
        }
        if let Some(scale) = &obstacle.scale {
            self.above(*scale.get_ref(), scale.span(), "scale", "")?;
        }
        for (what, length) in [("size", &obstacle.size), ("thickness", &obstacle.thickness)] {
            if let Some(length) = length {
                self.above(length.get_ref().si, length.span(), what, " m")?;
            }
        }
        self.friction(&obstacle.friction)?;
        self.path(obstacle.path.get_ref(), &format!("obstacle `{name}`"), obstacle.path.span())?;
        let turns = &obstacle.rotation_path;
        self.path(turns.get_ref(), &format!("the rotation of obstacle `{name}`"), turns.span())?;
        self.restitution(obstacle.restitution.as_ref())?;
        if scene.time.integrator == IntegratorChoice::QuasiStatic {
            let text = format!(
                "obstacle `{name}` with `integrator = \"quasi-static\"`; allowed is an integrator with inertia, as `backward-euler`: an equilibrium \
                 without contact need not exist"
            );
            return self.wrong(span, text);
        }
        Ok(())
    }

    fn friction(&self, friction: &Spanned<[f64; 2]>) -> Result<(), SceneError> {
        let [fixed, sliding] = *friction.get_ref();
        if fixed >= sliding && sliding >= 0.0 && fixed.is_finite() {
            return Ok(());
        }
        let text = format!(
            "friction [{fixed}, {sliding}]; allowed is [to start, while sliding], 0 or more, the first not lower"
        );
        self.wrong(friction.span(), text)
    }

    fn device(&self, device: &DeviceScene) -> Result<(), SceneError> {
        match (&device.recording, &device.recorded) {
            (None, Some(recorded)) => {
                self.wrong(recorded.span(), "`recorded` names a device of a `recording`, and there is none")
            }
            (Some(recording), _) if device.plugin.span() != (0..0) || !device.params.is_empty() => {
                let text = "`recording` and a plugin with `params`; allowed is one of them";
                self.wrong(recording.span(), text)
            }
            _ => Ok(()),
        }
    }

    fn tool(&self, tool: &ToolScene) -> Result<(), SceneError> {
        if let Some(radius) = &tool.radius {
            self.above(radius.get_ref().si, radius.span(), "radius", " m")?;
        }
        self.above(tool.speed.get_ref().si, tool.speed.span(), "speed", " m/s")?;
        self.above(tool.slew.get_ref().si, tool.slew.span(), "slew", " N/s")?;
        if let Some(mass) = &tool.mass {
            self.above(mass.get_ref().si, mass.span(), "mass", " kg")?;
        }
        if let Some(k) = &tool.stiffness {
            self.above(k.get_ref().si, k.span(), "stiffness", " N/m")?;
        }
        if let Some(b) = tool.damping.as_ref().filter(|b| b.get_ref().si < 0.0) {
            let text = format!("damping is {} N s/m; allowed is 0 or more", b.get_ref().si);
            return self.wrong(b.span(), text);
        }
        if let Some(blade) = &tool.blade {
            self.blade(blade.get_ref())?;
        }
        self.friction(&tool.friction)?;
        self.restitution(tool.restitution.as_ref())?;
        self.contact_law(tool)
    }

    /// Checks that keys that a contact law takes the place of are not given beside one.
    fn contact_law(&self, tool: &ToolScene) -> Result<(), SceneError> {
        let Some(law) = &tool.contact_law else { return Ok(()) };
        let law = law.get_ref().plugin.get_ref();
        let friction = Some(tool.friction.span()).filter(|span| *span != (0..0));
        let replaced = [("friction", friction), ("restitution", tool.restitution.as_ref().map(Spanned::span))];
        if let Some((key, Some(span))) = replaced.into_iter().find(|(_, span)| span.is_some()) {
            let text =
                format!("`{key}` of a tool with the contact law `{law}`, which has its own; allowed is one of them");
            return self.wrong(span, text);
        }
        match tool.sheets.as_ref().filter(|sheets| *sheets.get_ref() != SheetContact::Penalty) {
            Some(sheets) => {
                let text = format!(
                    "`sheets` of a tool with the contact law `{law}`; allowed is \"penalty\", or no `sheets`: a law gives forces, and the other methods \
                     are constraints and multipliers"
                );
                self.wrong(sheets.span(), text)
            }
            None => Ok(()),
        }
    }

    fn restitution(&self, restitution: Option<&Spanned<f64>>) -> Result<(), SceneError> {
        match restitution.filter(|e| !(0.0..=1.0).contains(e.get_ref())) {
            Some(e) => self.wrong(e.span(), format!("restitution {}; allowed is 0 to 1", e.get_ref())),
            None => Ok(()),
        }
    }

    fn blade(&self, blade: &BladeScene) -> Result<(), SceneError> {
        self.above(blade.length.get_ref().si, blade.length.span(), "length of the blade", " m")?;
        for (value, span, what) in [
            (blade.toughness.get_ref().si, blade.toughness.span(), "toughness is {} J/m^2"),
            (blade.tear.get_ref().si, blade.tear.span(), "tear is {} N"),
        ] {
            if value < 0.0 {
                let text = format!("{}; allowed is 0 or more", what.replace("{}", &value.to_string()));
                return self.wrong(span, text);
            }
        }
        let direction = blade.direction.get_ref();
        if !(direction.iter().all(|c| c.is_finite()) && direction.iter().any(|c| *c != 0.0)) {
            let text = format!("direction of the blade is {direction:?}; allowed is finite numbers, not all 0");
            return self.wrong(blade.direction.span(), text);
        }
        let material = blade.material.get_ref();
        if material.is_empty() || material.contains(|c: char| c.is_whitespace() || c.is_control()) {
            return self
                .wrong(blade.material.span(), format!("material {material:?}; allowed is a name without spaces"));
        }
        Ok(())
    }

    /// The edit kind, or undo or redo, of an edit.
    fn command(&self, edit: &EditScene) -> Result<Command, SceneError> {
        let name = &edit.kind.get_ref().0;
        Command::find(name).ok_or_else(|| {
            let known: Vec<String> = Command::names().map(|(name, _)| format!("`{name}`")).collect();
            self.0.error(edit.kind.span(), format!("edit kind `{name}`; allowed is {}", known.join(", ")))
        })
    }

    fn edit(&self, edit: &EditScene) -> Result<(), SceneError> {
        let is_history = matches!(self.command(edit)?, Command::Undo | Command::Redo);
        match &edit.tool {
            Some(tool) if is_history => return self.wrong(tool.span(), "`undo` and `redo` have no tool"),
            None if !is_history => {
                return Err(self.0.whole("an [[edit]] without `tool`; only `undo` and `redo` have none"));
            }
            _ => {}
        }
        if let Some(start) = edit.start.as_ref().filter(|t| t.get_ref().si < 0.0) {
            let text = format!("start is {} s; allowed is 0 or more", start.get_ref().si);
            return self.wrong(start.span(), text);
        }
        let start = edit.start.as_ref().map_or(0.0, |t| t.get_ref().si);
        if let Some(end) = edit.end.as_ref().filter(|t| t.get_ref().si <= start) {
            let text = format!("end is {} s; allowed is after the start at {start} s", end.get_ref().si);
            return self.wrong(end.span(), text);
        }
        if let Some(limit) = &edit.limit {
            self.above(limit.get_ref().si, limit.span(), "limit", " N")?;
        }
        if let Some(radius) = &edit.radius {
            self.above(radius.get_ref().si, radius.span(), "radius", " m")?;
        }
        self.keys(edit)?;
        match &edit.button {
            Some(button) if *button.get_ref() >= BUTTONS => {
                self.wrong(button.span(), format!("button {}; allowed is 0 to {}", button.get_ref(), BUTTONS - 1))
            }
            _ => Ok(()),
        }
    }

    /// Checks that the kind of the edit reads every key given.
    fn keys(&self, edit: &EditScene) -> Result<(), SceneError> {
        let given = [
            (KeyName::Limit, edit.limit.as_ref().map(Spanned::span)),
            (KeyName::Radius, edit.radius.as_ref().map(Spanned::span)),
            (KeyName::Falloff, edit.falloff.as_ref().map(Spanned::span)),
            (KeyName::Strength, edit.strength.as_ref().map(Spanned::span)),
            (KeyName::Param, edit.param.as_ref().map(Spanned::span)),
            (KeyName::Depth, edit.depth.as_ref().map(Spanned::span)),
            (KeyName::Split, edit.split.as_ref().map(Spanned::span)),
        ];
        let (name, known) = match self.command(edit)? {
            Command::Tool(kind) => (kind.name(), kind.keys()),
            Command::Undo | Command::Redo => (edit.kind.get_ref().0.as_str(), [].as_slice()),
        };
        for (key, span) in given.into_iter().filter_map(|(key, span)| Some((key, span?))) {
            if known.iter().any(|k| k.name == key) {
                continue;
            }
            let list: Vec<String> = known.iter().map(|k| format!("`{}`", k.name.as_str())).collect();
            let allowed = if list.is_empty() { "none of these keys".into() } else { list.join(", ") };
            let text = format!("edit kind `{name}` does not read `{}`; it reads {allowed}", key.as_str());
            return self.wrong(span, text);
        }
        Ok(())
    }

    fn probe(&self, probe: &ProbeScene, duration: f64) -> Result<(), SceneError> {
        self.above(*probe.tolerance.get_ref(), probe.tolerance.span(), "tolerance", "")?;
        if let Some(expected) = probe.expected.as_ref().filter(|e| !e.get_ref().is_finite()) {
            return self
                .wrong(expected.span(), format!("expected is {}; allowed is a finite number", expected.get_ref()));
        }
        match &probe.time {
            Some(time) if !(0.0..=duration).contains(&time.get_ref().si) => {
                let text = format!("time is {} s; allowed is 0 to {duration} s, the scene's end", time.get_ref().si);
                self.wrong(time.span(), text)
            }
            _ => Ok(()),
        }
    }
}
