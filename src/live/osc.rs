//! Packets of Open Sound Control 1.0, into messages and back: <https://opensoundcontrol.stanford.edu/spec-1_0.html>.

/// How many bundles a packet may have, beside each other or within: a packet of a sender has one or a few. Without a
/// limit a packet of 64 KiB is thousands of them, one in the other.
const MOST_BUNDLES: usize = 64;

/// The mark of a bundle.
const BUNDLE: &[u8] = b"#bundle\0";

/// The time of a bundle that is to be heard at once.
const NOW: [u8; 8] = 1_u64.to_be_bytes();

/// Texts and blobs are padded with zeros to a multiple of so many bytes.
const ALIGNMENT: usize = 4;

/// Bytes of a bundle before its messages, and before each of them.
pub(super) const BEFORE_MESSAGES: usize = BUNDLE.len() + NOW.len();
pub(super) const BEFORE_MESSAGE: usize = 4;

/// An argument of a message.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Argument {
    Int(i32),
    Float(f32),
    Double(f64),
    Text(String),
    /// Nothing, or a value of a type that no message of VMC has.
    Nil,
}

/// A message: what it is about, and its arguments.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Message {
    pub(super) address: String,
    pub(super) arguments: Vec<Argument>,
}

/// The messages of a packet, in their order; `None` where it is no OSC.
pub(super) fn messages(packet: &[u8]) -> Option<Vec<Message>> {
    let (mut found, mut open, mut bundles) = (Vec::new(), vec![packet], 0);
    while let Some(packet) = open.pop() {
        let Some(elements) = packet.strip_prefix(BUNDLE) else {
            found.push(Bytes(packet).message()?);
            continue;
        };
        bundles += 1;
        if bundles > MOST_BUNDLES {
            return None;
        }
        let mut elements = Bytes(elements);
        elements.take(NOW.len())?;
        let first = open.len();
        while !elements.0.is_empty() {
            let length = u32::from_be_bytes(elements.array()?);
            open.push(elements.take(length as usize)?);
        }
        // Backwards, because the last of a stack comes first.
        open[first..].reverse();
    }
    Some(found)
}

/// The bytes of a bundle of messages, each as [`Message::bytes`] gives it.
pub(super) fn bundle(messages: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = [BUNDLE, &NOW].concat();
    for message in messages {
        bytes.extend((message.len() as u32).to_be_bytes());
        bytes.extend(message);
    }
    bytes
}

impl Message {
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put_text(&mut bytes, &self.address);
        let tags = self.arguments.iter().map(|argument| match argument {
            Argument::Int(_) => 'i',
            Argument::Float(_) => 'f',
            Argument::Double(_) => 'd',
            Argument::Text(_) => 's',
            Argument::Nil => 'N',
        });
        put_text(&mut bytes, &std::iter::once(',').chain(tags).collect::<String>());
        for argument in &self.arguments {
            match argument {
                Argument::Int(value) => bytes.extend(value.to_be_bytes()),
                Argument::Float(value) => bytes.extend(value.to_be_bytes()),
                Argument::Double(value) => bytes.extend(value.to_be_bytes()),
                Argument::Text(text) => put_text(&mut bytes, text),
                Argument::Nil => {}
            }
        }
        bytes
    }
}

/// A text ends with a zero at least.
fn put_text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend(text.as_bytes());
    bytes.push(0);
    bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
}

/// What is left to read.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, left) = self.0.split_at_checked(count)?;
        self.0 = left;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = memchr::memchr(0, self.0)?;
        let padded = self.take((length + 1).next_multiple_of(ALIGNMENT))?;
        std::str::from_utf8(&padded[..length]).ok()
    }

    fn message(mut self) -> Option<Message> {
        let address = self.text().filter(|address| address.starts_with('/'))?;
        // Old senders leave the types out where there is no argument.
        let tags = if self.0.is_empty() { "," } else { self.text()? };
        let tags = tags.strip_prefix(',')?.bytes();
        Some(Message {
            address: address.to_owned(),
            arguments: tags.map(|tag| self.argument(tag)).collect::<Option<_>>()?,
        })
    }

    fn argument(&mut self, tag: u8) -> Option<Argument> {
        let other_type = match tag {
            b'i' => return Some(Argument::Int(i32::from_be_bytes(self.array()?))),
            b'f' => return Some(Argument::Float(f32::from_be_bytes(self.array()?))),
            b'd' => return Some(Argument::Double(f64::from_be_bytes(self.array()?))),
            b's' => return Some(Argument::Text(self.text()?.to_owned())),
            // A symbol; a character, a colour, a MIDI message; a 64-bit integer, a time; a blob; true, false, nil, a
            // trigger, and the ends of a list.
            b'S' => self.text().map(|_| ()),
            b'c' | b'r' | b'm' => self.take(4).map(|_| ()),
            b'h' | b't' => self.take(8).map(|_| ()),
            b'b' => {
                let length = u32::from_be_bytes(self.array()?) as usize;
                self.take(length.checked_next_multiple_of(ALIGNMENT)?).map(|_| ())
            }
            b'T' | b'F' | b'N' | b'I' | b'[' | b']' => Some(()),
            _ => None,
        };
        other_type.map(|()| Argument::Nil)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of the specification.
    #[test]
    fn a_message_has_the_bytes_of_the_specification() {
        let frequency = Message {
            address: "/oscillator/4/frequency".to_owned(),
            arguments: vec![Argument::Float(440.0)],
        };
        let expected = b"/oscillator/4/frequency\0,f\0\0\x43\xdc\0\0";
        assert_eq!(frequency.bytes(), expected);
        assert_eq!(messages(expected), Some(vec![frequency.clone()]));

        let text = Argument::Text("hello".to_owned());
        let foo = Message {
            address: "/foo".to_owned(),
            arguments: vec![
                Argument::Int(1000),
                Argument::Int(-1),
                text,
                Argument::Float(1.234),
                Argument::Float(5.678),
            ],
        };
        let expected = b"/foo\0\0\0\0,iisff\0\0\0\0\x03\xe8\xff\xff\xff\xffhello\0\0\0\x3f\x9d\xf3\xb6\x40\xb5\xb2\x2d";
        assert_eq!(foo.bytes(), expected);
        let both = bundle(&[frequency.bytes(), foo.bytes()]);
        assert_eq!(messages(&both), Some(vec![frequency.clone(), foo.clone()]));
        let nested = bundle(&[both, foo.bytes()]);
        assert_eq!(messages(&nested), Some(vec![frequency, foo.clone(), foo]));
        for cut in 1..nested.len() {
            assert!(messages(&nested[..cut]).is_none_or(|found| found.len() < 3), "{cut}");
        }
    }

    #[test]
    fn values_of_other_types_are_passed_over() {
        let packet = b"/a\0\0,bhTfrS[i]\0\0\0\0\0\x03abc\0\0\0\0\0\0\0\0\x09\x3f\x80\0\0RGBAsym\0\0\0\0\x07";
        let found = messages(packet).unwrap();
        let nil = Argument::Nil;
        let expected = [
            nil.clone(),
            nil.clone(),
            nil.clone(),
            Argument::Float(1.0),
            nil.clone(),
            nil.clone(),
            nil.clone(),
            Argument::Int(7),
            nil,
        ];
        assert_eq!(found[0].arguments, expected);
        assert_eq!(messages(b"/a\0\0,?\0\0"), None);
        assert_eq!(messages(b"/a\0\0,b\0\0\xff\xff\xff\xff"), None);
        assert_eq!(messages(b"GET / HTTP/1.1\0\0"), None);
        assert_eq!(messages(b"/a\0\0").unwrap()[0].arguments, []);
        assert_eq!(messages(b""), None);
    }
}
