// The template in the repository is what its sources make.
import { spawnSync } from "node:child_process";
import { join } from "node:path";
import { packageOf } from "./chromium.mjs";

const page = join(process.argv[2], "stages/report/page");
packageOf(process.argv[2], "esbuild");
for (const [program, ...rest] of [["build.mjs", "--check"], ["node_modules/typescript/bin/tsc", "--noEmit"]]) {
  const { status } = spawnSync(process.execPath, [program, ...rest], { cwd: page, stdio: "inherit" });
  if (status !== 0) process.exit(1);
}
