// node read_mcap.cjs FILE.mcap FOLDER: all messages of a file as JSON, one a line, decoded as Lichtblick does: by @mcap/core,
// @mcap/support and the schemas that are in the file. FOLDER: where `make npm` has put these packages.
const fs = require("fs");
const { createRequire } = require("module");
const from = createRequire(process.argv[3] + "/");
const { McapIndexedReader } = from("@mcap/core");
const { loadDecompressHandlers, protobufFromBinaryDescriptor } = from("@mcap/support");
const { parse } = from("@foxglove/rosmsg");
const { MessageReader } = from("@foxglove/rosmsg2-serialization");

function decoderOf(channel, schema) {
  if (schema.encoding === "ros2msg" && channel.messageEncoding === "cdr") {
    const reader = new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true }));
    return (data) => reader.readMessage(data);
  }
  if (schema.encoding === "protobuf" && channel.messageEncoding === "protobuf") {
    const type = protobufFromBinaryDescriptor(schema.data).lookupType(schema.name);
    return (data) => type.toObject(type.decode(data), { defaults: true, longs: String, bytes: Array });
  }
  throw new Error(`cannot decode ${channel.messageEncoding} of ${schema.encoding}`);
}

function plain(_key, value) {
  if (typeof value === "bigint") return value.toString();
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
}

async function main() {
  const file = fs.readFileSync(process.argv[2]);
  const readable = {
    size: async () => BigInt(file.length),
    read: async (offset, length) => new Uint8Array(file.subarray(Number(offset), Number(offset + length))),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
  const decoders = new Map();
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!decoders.has(channel.id)) decoders.set(channel.id, decoderOf(channel, schema));
    const content = decoders.get(channel.id)(message.data);
    const line = { topic: channel.topic, schema: schema.name, logTime: message.logTime, message: content };
    process.stdout.write(JSON.stringify(line, plain) + "\n");
  }
}

main().catch((error) => {
  console.error(String(error));
  process.exit(1);
});
