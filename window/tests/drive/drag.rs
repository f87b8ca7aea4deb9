//! A file manager's part of a drag: the source of XDND, version 5, moved by the pointer of the display.

use crate::display::{Display, PATIENCE};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    Atom, AtomEnum, ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, PropMode, SELECTION_NOTIFY_EVENT,
    SelectionNotifyEvent, SelectionRequestEvent, Window, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT};

x11rb::atom_manager! {
    Atoms: AtomsCookie {
        XdndAware,
        XdndProxy,
        XdndEnter,
        XdndPosition,
        XdndStatus,
        XdndLeave,
        XdndDrop,
        XdndFinished,
        XdndSelection,
        XdndActionCopy,
        TARGETS,
        URI_LIST: b"text/uri-list",
        PLAIN_TEXT: b"text/plain",
    }
}

/// Version of XDND that the source speaks.
const VERSION: u32 = 5;
/// Where the source's window lies, over a corner of the picture: x, y, width, height in pixels.
const CORNER: (i16, i16, u16, u16) = (0, 760, 40, 40);

/// How a source speaks.
#[derive(Clone, Copy, Default)]
pub struct Habits {
    /// It sends its messages to the window itself, also where another one takes them in its place.
    pub ignores_proxies: bool,
    /// It gives the list of files only after they were let go.
    pub answers_late: bool,
}

/// What a source is told of its drag.
#[derive(Debug, PartialEq, Eq)]
pub struct Finished {
    /// Whether the target took what was dropped.
    pub is_accepted: bool,
    /// How often the target asked for the list of files.
    pub requests: usize,
}

/// A drag under way: the button is held, and the pointer is over the target.
pub struct Drag<'a> {
    display: &'a Display,
    server: RustConnection,
    atoms: Atoms,
    root: Window,
    source: Window,
    target: Window,
    /// The window that takes messages for the target.
    address: Window,
    /// Requests of the list of files that are not answered yet.
    held: Vec<SelectionRequestEvent>,
    habits: Habits,
    /// Bytes of the type text/uri-list.
    list: Vec<u8>,
    requests: usize,
}

impl<'a> Drag<'a> {
    /// Takes hold of files and moves them to a place, until the target has said that it accepts them.
    pub fn start(display: &'a Display, list: impl Into<Vec<u8>>, to: [i32; 2], habits: Habits) -> Self {
        let (server, screen) = x11rb::connect(Some(&display.name)).unwrap();
        let atoms = Atoms::new(&server).unwrap().reply().unwrap();
        let root = server.setup().roots[screen].root;
        let source = server.generate_id().unwrap();
        let (x, y, width, height) = CORNER;
        // Without a window manager it is shown where it says, over what was there before.
        let events = EventMask::BUTTON_PRESS | EventMask::BUTTON_RELEASE | EventMask::BUTTON_MOTION;
        let aux = CreateWindowAux::new().event_mask(events | EventMask::EXPOSURE).override_redirect(1);
        let class = WindowClass::INPUT_OUTPUT;
        let (depth, visual) = (COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT);
        server.create_window(depth, source, root, x, y, width, height, 0, class, visual, &aux).unwrap();
        server.map_window(source).unwrap().check().unwrap();
        let (held, list) = (Vec::new(), list.into());
        let mut drag =
            Self { display, server, atoms, root, source, target: root, address: root, held, habits, list, requests: 0 };
        drag.wait("its window", |event| matches!(event, Event::Expose(_)).then_some(()));

        display.move_to([i32::from(x) + 20, i32::from(y) + 20]);
        display.xdotool(&["mousedown", "1"]);
        let pressed = drag.wait("the button", |event| match event {
            Event::ButtonPress(event) => Some(event.time),
            _ => None,
        });
        drag.server.set_selection_owner(source, atoms.XdndSelection, pressed).unwrap().check().unwrap();
        // The button grabs the pointer, so the source sees it move over other windows.
        display.move_to(to);
        let moved = drag.wait("the move", |event| match event {
            Event::MotionNotify(event) if [event.root_x, event.root_y].map(i32::from) == to => Some(event.time),
            _ => None,
        });
        drag.target = drag.target_at(to).expect("a window at this place takes drops");
        drag.address = drag.proxy_of_target().filter(|_| !habits.ignores_proxies).unwrap_or(drag.target);
        drag.send(atoms.XdndEnter, [VERSION << 24, atoms.URI_LIST, atoms.PLAIN_TEXT, 0]);
        let at = to.map(|coordinate| coordinate as u32);
        drag.send(atoms.XdndPosition, [0, at[0] << 16 | at[1], moved, atoms.XdndActionCopy]);
        assert!(drag.status(), "the target accepts a list of files");
        drag
    }

    /// Lets the files go, and gives what the target says of them.
    pub fn let_go(mut self) -> Finished {
        let released = self.release();
        self.send(self.atoms.XdndDrop, [0, released, 0, 0]);
        self.habits.answers_late = false;
        std::mem::take(&mut self.held).into_iter().for_each(|request| self.answer(request));
        let (target, finished) = (self.target, self.atoms.XdndFinished);
        let is_accepted = self.wait("XdndFinished", |event| match event {
            Event::ClientMessage(event) if event.type_ == finished => {
                let data = event.data.as_data32();
                assert_eq!(data[0], target, "it says which window it is");
                Some(data[1] & 1 == 1)
            }
            _ => None,
        });
        Finished { is_accepted, requests: self.requests }
    }

    /// Drags the files away again.
    pub fn leave(mut self) {
        self.send(self.atoms.XdndLeave, [0; 4]);
        self.release();
    }

    /// Lets the button go; gives when.
    fn release(&mut self) -> u32 {
        self.display.xdotool(&["mouseup", "1"]);
        self.wait("the button", |event| match event {
            Event::ButtonRelease(event) => Some(event.time),
            _ => None,
        })
    }

    /// Whether the target accepts what is over it.
    fn status(&mut self) -> bool {
        let (target, status) = (self.target, self.atoms.XdndStatus);
        self.wait("XdndStatus", |event| match event {
            Event::ClientMessage(event) if event.type_ == status => {
                let data = event.data.as_data32();
                assert_eq!(data[0], target, "it says which window it is");
                Some(data[1] & 1 == 1)
            }
            _ => None,
        })
    }

    /// The outermost window at a place that takes drops, of those that are not the source's.
    fn target_at(&self, [x, y]: [i32; 2]) -> Option<Window> {
        let mut window = self.root;
        loop {
            let at = self.server.translate_coordinates(self.root, window, x as i16, y as i16).unwrap().reply().unwrap();
            if at.child == x11rb::NONE {
                return None;
            }
            window = at.child;
            let aware = self.server.get_property(false, window, self.atoms.XdndAware, AtomEnum::ATOM, 0, 1);
            if aware.unwrap().reply().unwrap().value32().and_then(|mut versions| versions.next()) >= Some(VERSION) {
                return Some(window);
            }
        }
    }

    /// The window that takes messages in the place of the target: it says so itself, and takes drops.
    fn proxy_of_target(&self) -> Option<Window> {
        let value = |window, name, kind| {
            let property = self.server.get_property(false, window, name, kind, 0, 1).unwrap().reply().ok()?;
            property.value32()?.next()
        };
        let proxy = value(self.target, self.atoms.XdndProxy, AtomEnum::WINDOW)?;
        let says_so = value(proxy, self.atoms.XdndProxy, AtomEnum::WINDOW) == Some(proxy);
        (says_so && value(proxy, self.atoms.XdndAware, AtomEnum::ATOM) >= Some(VERSION)).then_some(proxy)
    }

    /// Sends the target a message that begins with the source's window.
    fn send(&self, kind: Atom, [a, b, c, d]: [u32; 4]) {
        let message = ClientMessageEvent::new(32, self.target, kind, [self.source, a, b, c, d]);
        self.server.send_event(false, self.address, EventMask::NO_EVENT, message).unwrap().check().unwrap();
    }

    /// Waits for an event, and answers whoever asks for the list of files meanwhile.
    fn wait<T>(&mut self, what: &str, mut take: impl FnMut(&Event) -> Option<T>) -> T {
        let began = Instant::now();
        loop {
            while let Some(event) = self.server.poll_for_event().unwrap() {
                if let Event::SelectionRequest(request) = event {
                    match self.habits.answers_late {
                        true => self.held.push(request),
                        false => self.answer(request),
                    }
                } else if let Some(taken) = take(&event) {
                    return taken;
                }
            }
            assert!(began.elapsed() < PATIENCE, "the source of a drag waited for {what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Gives the list of files to whoever asks for it, and refuses other types.
    fn answer(&mut self, request: SelectionRequestEvent) {
        let (server, atoms) = (&self.server, self.atoms);
        let (window, property) = (request.requestor, request.property);
        let is_known = request.target == atoms.URI_LIST || request.target == atoms.TARGETS;
        if request.target == atoms.URI_LIST {
            self.requests += 1;
            server.change_property8(PropMode::REPLACE, window, property, atoms.URI_LIST, &self.list).unwrap();
        } else if is_known {
            let types = [atoms.TARGETS, atoms.URI_LIST];
            server.change_property32(PropMode::REPLACE, window, property, AtomEnum::ATOM, &types).unwrap();
        }
        let answer = SelectionNotifyEvent {
            response_type: SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time: request.time,
            requestor: window,
            selection: request.selection,
            target: request.target,
            property: if is_known { property } else { x11rb::NONE },
        };
        server.send_event(false, window, EventMask::NO_EVENT, answer).unwrap().check().unwrap();
    }
}

/// A list of files as file managers write it: a URI on each line, all bytes but those of RFC 3986's unreserved ones and slashes percent-encoded.
pub fn uri_list(paths: &[&std::path::Path]) -> String {
    let mut list = String::new();
    for path in paths {
        list.push_str("file://");
        for byte in path.to_str().unwrap().bytes() {
            match byte {
                b'/' | b'-' | b'.' | b'_' | b'~' => list.push(byte.into()),
                _ if byte.is_ascii_alphanumeric() => list.push(byte.into()),
                _ => list.push_str(&format!("%{byte:02X}")),
            }
        }
        list.push_str("\r\n");
    }
    list
}
