//! How a block of numbers is taken from the region's table. Sans-IO.

/// Number of the last taken blocks that are checked for a repeated request: a new owner repeats requests that were answered
/// already.
const LATEST: usize = 4;

/// A request for entries of the table, by the index of the block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BlockRequest {
    /// List the blocks that are taken.
    List,
    /// Read the name that has a block.
    Read(u32),
    /// Write the name of this request into the block if it is free.
    Create(u32),
}

/// Answer to a [`BlockRequest`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BlockAnswer {
    /// The blocks that are taken.
    Taken(Vec<u32>),
    /// Name that has the block; `None` if it is free.
    Name(Option<String>),
    /// The name was written.
    Created,
    /// Another name is there.
    Exists,
}

/// Next step of the procedure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockStep {
    Request(BlockRequest),
    /// Index of the block; `None` if all are taken.
    End(Option<u32>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Stage {
    List,
    /// Reads the block with this index among those taken.
    Latest(usize),
    Create(u32),
    Check(u32),
}

/// Takes a block under the name of a request. A repeated request finds the block that it has taken before.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct BlockProcedure {
    name: String,
    /// Number of blocks of the table.
    blocks: u32,
    /// Blocks that were taken at the beginning, sorted.
    taken: Vec<u32>,
    stage: Stage,
}

impl BlockProcedure {
    /// Takes a block of a table with this number of blocks, under the name of the request.
    pub(crate) fn take(name: String, blocks: u32) -> (Self, BlockRequest) {
        (Self { name, blocks, taken: Vec::new(), stage: Stage::List }, BlockRequest::List)
    }

    /// Handles the answer to the last request.
    pub(crate) fn handle(&mut self, answer: BlockAnswer) -> BlockStep {
        match (self.stage, answer) {
            (Stage::List, BlockAnswer::Taken(mut taken)) => {
                taken.retain(|block| *block < self.blocks);
                taken.sort_unstable();
                self.taken = taken;
                self.look(self.taken.len())
            }
            (Stage::Latest(index), BlockAnswer::Name(name)) => match self.is_own(name.as_ref()) {
                true => BlockStep::End(Some(self.taken[index])),
                false => self.look(index),
            },
            (Stage::Create(block), BlockAnswer::Created) => BlockStep::End(Some(block)),
            (Stage::Create(block), _) => self.request(Stage::Check(block), BlockRequest::Read(block)),
            (Stage::Check(block), BlockAnswer::Name(Some(name))) => match name == self.name {
                true => BlockStep::End(Some(block)),
                false => self.create(block + 1),
            },
            // The entry may have been deleted since.
            (Stage::Check(block), _) => self.create(block),
            (Stage::List | Stage::Latest(_), _) => self.create(0),
        }
    }

    fn is_own(&self, name: Option<&String>) -> bool {
        name == Some(&self.name)
    }

    /// Reads the block before the one with this index, among the last ones taken.
    fn look(&mut self, index: usize) -> BlockStep {
        match index.checked_sub(1).filter(|before| before + LATEST >= self.taken.len()) {
            Some(before) => self.request(Stage::Latest(before), BlockRequest::Read(self.taken[before])),
            None => self.create(0),
        }
    }

    /// Writes the name into the first block from this one on that was not taken.
    fn create(&mut self, from: u32) -> BlockStep {
        match (from..self.blocks).find(|block| self.taken.binary_search(block).is_err()) {
            Some(block) => self.request(Stage::Create(block), BlockRequest::Create(block)),
            None => BlockStep::End(None),
        }
    }

    fn request(&mut self, stage: Stage, request: BlockRequest) -> BlockStep {
        self.stage = stage;
        BlockStep::Request(request)
    }
}
