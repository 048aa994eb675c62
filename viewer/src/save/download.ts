/** Handing files to the browser. */

/** Offer a file for download. */
export function download(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export function textBlob(text: string): Blob {
  return new Blob([text], { type: "text/plain" });
}
