import type { App } from "./app";

declare global {
  interface Window {
    meshmser?: App; // for looking into a page from the browser's console, and for its tests
  }
}
