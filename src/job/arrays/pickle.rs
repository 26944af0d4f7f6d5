//! Python pickles (protocol 4) of dictionaries with NumPy arrays. `pickle.load` reads them if NumPy is installed.

use mocap_scene::files::ARRAY_MARK;

/// The instructions of a pickle.
pub(super) struct Pickle(Vec<u8>);

impl Pickle {
    /// A dictionary with the entries that `fill` adds: for each the key as text, then the value.
    pub(super) fn dictionary(fill: impl FnOnce(&mut Self)) -> Vec<u8> {
        let mut pickle = Self(vec![0x80, 4]);
        // A string that is pushed and popped again. The string records in the file that mocap wrote the pickle.
        pickle.text(ARRAY_MARK);
        pickle.0.push(b'0');
        pickle.entries(fill);
        pickle.0.push(b'.');
        pickle.0
    }

    /// A dictionary inside another.
    pub(super) fn entries(&mut self, fill: impl FnOnce(&mut Self)) {
        self.0.extend(b"}(");
        fill(self);
        self.0.push(b'u');
    }

    pub(super) fn text(&mut self, text: &str) {
        self.0.push(b'X');
        self.0.extend((text.len() as u32).to_le_bytes());
        self.0.extend(text.as_bytes());
    }

    pub(super) fn none(&mut self) {
        self.0.push(b'N');
    }

    /// A float, or an int if the value is whole.
    pub(super) fn number(&mut self, value: f64) {
        let whole = value as i32;
        if f64::from(whole) == value {
            self.0.push(b'J');
            self.0.extend(whole.to_le_bytes());
        } else {
            self.0.push(b'G');
            self.0.extend(value.to_be_bytes());
        }
    }

    pub(super) fn texts(&mut self, texts: &[String]) {
        self.0.extend(b"](");
        texts.iter().for_each(|text| self.text(text));
        self.0.push(b'e');
    }

    fn function(&mut self, name: &str) {
        self.0.extend(format!("cnumpy\n{name}\n").as_bytes());
    }

    /// `numpy.reshape(numpy.array(numpy.frombuffer(bytes, "<f8")), shape)`: these names exist in every NumPy version.
    /// The copy is writable.
    pub(super) fn array(&mut self, values: &[f64], shape: &[usize]) {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.numbers("<f8", bytes, shape);
    }

    /// An array of these values, rounded to float32.
    pub(super) fn floats(&mut self, values: &[f64], shape: &[usize]) {
        let bytes = values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
        self.numbers("<f4", bytes, shape);
    }

    fn numbers(&mut self, dtype: &str, bytes: Vec<u8>, shape: &[usize]) {
        self.function("reshape");
        self.function("array");
        self.function("frombuffer");
        self.0.push(0x8e);
        self.0.extend((bytes.len() as u64).to_le_bytes());
        self.0.extend(bytes);
        self.text(dtype);
        // Opcodes: make a tuple of two, call, make a tuple of one, call.
        self.0.extend([0x86, b'R', 0x85, b'R']);
        // Opcodes: mark, push the lengths, make a tuple of everything after the mark, make a tuple of two, call.
        self.0.push(b'(');
        for length in shape {
            self.0.push(b'J');
            self.0.extend((*length as i32).to_le_bytes());
        }
        self.0.extend([b't', 0x86, b'R']);
    }
}
