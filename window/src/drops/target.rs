//! The target of a drag (XDND, version 5), with a connection and a thread of its own.

use super::uri_list::files;
use super::{DragNews, DraggedFiles};
use std::sync::mpsc::{Receiver, Sender, channel};
use x11rb::connection::Connection;
use x11rb::errors::ReplyOrIdError;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    Atom, AtomEnum, ChangeWindowAttributesAux, ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, PropMode,
    SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT, NONE};

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
        XdndTypeList,
        XdndActionCopy,
        URI_LIST: b"text/uri-list",
    }
}

/// Version of the protocol.
const VERSION: u32 = 5;
/// Most types of data that a source offers, and most words of a list of files: 4 MB.
const MOST_TYPES: u32 = 1024;
/// See [`MOST_TYPES`].
const MOST_WORDS: u32 = 1 << 20;

/// Takes the drops of a window of the X server that `DISPLAY` names, on a thread of its own; `wake` is called there after each piece of news. Where that
/// fails, as where the system gives no thread, the window library still takes drops.
pub fn take_drops(window: u32, wake: impl Fn() + Send + 'static) -> Receiver<DragNews> {
    let (news, received) = channel();
    let run = move || {
        let Ok(mut target) = Target::new(window, news) else { return };
        // Without its server there is no window either.
        while let Ok(event) = target.server.wait_for_event() {
            match target.take(event) {
                Ok(true) => wake(),
                Ok(false) if !target.is_over => {}
                _ => return,
            }
        }
    };
    let _ = std::thread::Builder::new().name("drops".into()).spawn(run);
    received
}

/// A drag over the window.
struct Drag {
    source: Window,
    /// Whether a list of files is among the types that it offers.
    is_taken: bool,
    /// Whether the list was asked for.
    is_asked: bool,
    /// The list, once it has come.
    list: Option<DraggedFiles>,
    /// Whether it was let go.
    is_dropped: bool,
}

struct Target {
    server: RustConnection,
    atoms: Atoms,
    /// The window of the program.
    window: Window,
    /// The window that takes the messages.
    proxy: Window,
    host: String,
    drag: Option<Drag>,
    news: Sender<DragNews>,
    /// Whether the window of the program has gone.
    is_over: bool,
}

impl Target {
    fn new(window: Window, news: Sender<DragNews>) -> Result<Self, Box<dyn std::error::Error>> {
        let (server, screen) = x11rb::connect(None)?;
        let atoms = Atoms::new(&server)?.reply()?;
        let root = server.setup().roots[screen].root;
        let proxy = server.generate_id()?;
        let (depth, visual) = (COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT);
        let aux = CreateWindowAux::new().override_redirect(1);
        server.create_window(depth, proxy, root, -1, -1, 1, 1, 0, WindowClass::INPUT_ONLY, visual, &aux)?.check()?;
        server.change_property32(PropMode::REPLACE, proxy, atoms.XdndAware, AtomEnum::ATOM, &[VERSION])?.check()?;
        for of in [proxy, window] {
            server.change_property32(PropMode::REPLACE, of, atoms.XdndProxy, AtomEnum::WINDOW, &[proxy])?.check()?;
        }
        let events = ChangeWindowAttributesAux::new().event_mask(EventMask::STRUCTURE_NOTIFY);
        server.change_window_attributes(window, &events)?.check()?;
        // A machine without a name writes none into its URIs.
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim().to_owned();
        Ok(Self { server, atoms, window, proxy, host, drag: None, news, is_over: false })
    }

    /// Takes in an event; gives whether there is news.
    fn take(&mut self, event: Event) -> Result<bool, ReplyOrIdError> {
        match event {
            Event::ClientMessage(message) if message.format == 32 => self.take_message(message),
            Event::SelectionNotify(notice) => self.take_list(notice),
            Event::DestroyNotify(gone) if gone.window == self.window => {
                self.is_over = true;
                Ok(false)
            }
            _ => Ok(false),
        }
    }

    fn take_message(&mut self, message: ClientMessageEvent) -> Result<bool, ReplyOrIdError> {
        let data = message.data.as_data32();
        let (kind, source, atoms) = (message.type_, data[0], self.atoms);
        if kind == atoms.XdndEnter {
            let is_taken = self.types(source, data)?.contains(&atoms.URI_LIST);
            self.drag = Some(Drag { source, is_taken, is_asked: false, list: None, is_dropped: false });
            return Ok(false);
        }
        let Some(drag) = self.drag.as_mut().filter(|drag| drag.source == source) else { return Ok(false) };
        if kind == atoms.XdndPosition {
            let is_taken = drag.is_taken;
            if is_taken && !std::mem::replace(&mut drag.is_asked, true) {
                let (selection, list) = (atoms.XdndSelection, atoms.URI_LIST);
                self.server.convert_selection(self.proxy, selection, list, selection, data[3])?;
            }
            let action = if is_taken { atoms.XdndActionCopy } else { NONE };
            self.tell(source, atoms.XdndStatus, [u32::from(is_taken), 0, 0, action])?;
        } else if kind == atoms.XdndLeave && !drag.is_dropped {
            self.drag = None;
            return Ok(self.news.send(DragNews::Left).is_ok());
        } else if kind == atoms.XdndDrop {
            drag.is_dropped = true;
            // A list that was asked for may still be under way.
            if drag.list.is_some() || !drag.is_asked {
                return self.finish();
            }
        }
        Ok(false)
    }

    /// The types that a source offers: in its message up to three, otherwise in a property.
    fn types(&self, source: Window, data: [u32; 5]) -> Result<Vec<Atom>, ReplyOrIdError> {
        if data[1] & 1 == 0 {
            return Ok(data[2..].to_vec());
        }
        let list = self.server.get_property(false, source, self.atoms.XdndTypeList, AtomEnum::ATOM, 0, MOST_TYPES)?;
        // A source that has gone offers nothing.
        Ok(list.reply().ok().and_then(|list| Some(list.value32()?.collect())).unwrap_or_default())
    }

    /// Takes in the list of files that was asked for.
    fn take_list(&mut self, notice: SelectionNotifyEvent) -> Result<bool, ReplyOrIdError> {
        let Some(drag) = &mut self.drag else { return Ok(false) };
        let mut list = DraggedFiles::default();
        if notice.property != NONE {
            let read =
                self.server.get_property(true, self.proxy, notice.property, self.atoms.URI_LIST, 0, MOST_WORDS)?;
            for entry in read.reply().map(|read| files(&read.value, &self.host)).unwrap_or_default() {
                match entry {
                    Ok(path) => list.paths.push(path),
                    Err(uri) => list.others.push(uri),
                }
            }
        }
        drag.list = Some(list.clone());
        if drag.is_dropped {
            return self.finish();
        }
        Ok(self.news.send(DragNews::Over(list)).is_ok())
    }

    /// Hands on what was dropped, and tells its source.
    fn finish(&mut self) -> Result<bool, ReplyOrIdError> {
        let Some(drag) = self.drag.take() else { return Ok(false) };
        let (is_taken, action) = match &drag.list {
            Some(_) => (1, self.atoms.XdndActionCopy),
            None => (0, NONE),
        };
        self.tell(drag.source, self.atoms.XdndFinished, [is_taken, action, 0, 0])?;
        Ok(self.news.send(drag.list.map_or(DragNews::Left, DragNews::Dropped)).is_ok())
    }

    /// Sends the source a message that begins with the window of the program.
    fn tell(&self, source: Window, kind: Atom, [a, b, c, d]: [u32; 4]) -> Result<(), ReplyOrIdError> {
        let message = ClientMessageEvent::new(32, source, kind, [self.window, a, b, c, d]);
        self.server.send_event(false, source, EventMask::NO_EVENT, message)?;
        self.server.flush()?;
        Ok(())
    }
}
